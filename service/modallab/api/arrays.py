"""Replies that carry arrays."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import numpy as np
from fastapi import Query
from numpy.typing import NDArray
from starlette.responses import Response

from modallab.store.npz import pack, unpack

Precision = Annotated[
    Literal["double", "single"], Query(description="`single` halves the size: complex64 and float32")
]
MEDIA_TYPE = "application/x-npz"
# For the `responses` of a route that answers with arrays.
NPZ: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "Uncompressed npz",
        "content": {MEDIA_TYPE: {"schema": {"type": "string", "format": "binary"}}},
    }
}
_SINGLE = {"c": np.complex64, "f": np.float32}


def npz_reply(payload: bytes, precision: Literal["double", "single"] = "double") -> Response:
    """Return an npz file as a reply, its numbers shortened if that was asked for."""
    if precision == "single":
        payload = pack({name: _shortened(array) for name, array in unpack(payload).items()})
    return Response(payload, media_type=MEDIA_TYPE, headers={"Vary": "Accept"})


def npz_of(arrays: Mapping[str, NDArray[Any]], precision: Literal["double", "single"] = "double") -> Response:
    """Return arrays as an npz reply."""
    return npz_reply(pack(arrays), precision)


def _shortened(array: NDArray[Any]) -> NDArray[Any]:
    # The axis keeps its digits: neighbouring lines of a long record differ in the seventh.
    return (
        array
        if array.dtype.kind not in _SINGLE or array.ndim < 2
        else array.astype(_SINGLE[array.dtype.kind])
    )
