"""Named arrays as the bytes of an uncompressed npz file, and back."""

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray


def pack(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Return the arrays as an uncompressed npz file: the same arrays, the same bytes."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()


def unpack(payload: bytes) -> dict[str, NDArray[Any]]:
    """Return the arrays of an npz file that this service wrote."""
    with np.load(io.BytesIO(payload), allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def names(payload: bytes) -> list[str]:
    """Return the names of the arrays of an npz file that this service wrote."""
    with np.load(io.BytesIO(payload), allow_pickle=False) as file:
        return list(file.files)
