"""Arrays from npz files of unknown origin: every array is checked."""

import io
import zipfile
from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError

Arrays = dict[str, NDArray[Any]]


def load(payload: bytes, names: Collection[str] | None, largest: int) -> Arrays:
    """Return the arrays of these names that a npz file holds.

    Parameters
    ----------
    names
        Names wanted; None for all arrays of numbers and text.
    largest
        Bytes that all its arrays may take when unpacked.

    Raises
    ------
    InvalidInputError
        If it is no npz file, is damaged, or holds too much.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(payload)) as archive:
            members = {info.filename.removesuffix(".npy"): info for info in archive.infolist()}
            total = sum(info.file_size for info in members.values())
            if total > largest:
                raise InvalidInputError(
                    "the arrays are too large", field="file", value=total, allowed=largest
                )
            if names is None:
                arrays = {name: _array(archive, info) for name, info in members.items()}
                return {name: array for name, array in arrays.items() if array.dtype.kind in "iufcUS"}
            requested = [name for name in names if name in members]
            return {name: _array(archive, members[name]) for name in requested}
    except (
        zipfile.BadZipFile,
        zipfile.LargeZipFile,
        NotImplementedError,
        RuntimeError,
        EOFError,
        OSError,
    ) as error:
        raise InvalidInputError(f"not a npz file: {error}", field="file", allowed="npz") from None


def _array(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> NDArray[Any]:
    try:
        with archive.open(info) as raw:
            data = io.BytesIO(raw.read(info.file_size))
        version = npy.read_magic(data)
        read_header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, _, dtype = read_header(data)
        # A header may claim any size: numpy would allocate it before it finds the data missing.
        claimed = dtype.itemsize * int(np.prod(shape, dtype=object))
        if dtype.hasobject or claimed != len(data.getbuffer()) - data.tell():
            raise ValueError("its header does not fit its data")
        data.seek(0)
        return np.asarray(npy.read_array(data, allow_pickle=False))
    # Any: decompressors and the parser of numpy's headers raise a dozen kinds at hostile bytes.
    except Exception as error:
        raise InvalidInputError(f"cannot read {info.filename!r}: {error}", field=info.filename) from None


def numbers(arrays: Arrays, name: str, *ranks: int) -> NDArray[Any]:
    """Return an array as complex numbers, one of these ranks, all finite."""
    array = arrays[name]
    if array.dtype.kind not in "iufc" or array.ndim not in ranks:
        raise InvalidInputError(
            f"{name} has the wrong type or shape",
            field=name,
            value=f"{array.dtype} {array.shape}",
            allowed=f"numbers in {' or '.join(map(str, ranks))} dimensions",
        )
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        place = ", ".join(str(i) for i in bad[0].tolist())
        raise InvalidInputError(
            f"{name} holds a value that is not finite, at [{place}]",
            field=name,
            value="nan or inf",
            index=place,
        )
    return array.astype(complex)


def reals(arrays: Arrays, name: str, *ranks: int) -> FloatArray:
    """Return an array as real numbers, one of these ranks, all finite."""
    array = numbers(arrays, name, *ranks)
    if array.imag.any():
        raise InvalidInputError(f"{name} is not real", field=name, value="complex", allowed="real numbers")
    return array.real


def texts(array: NDArray[Any], name: str) -> list[str]:
    """Return an array of strings, one after the other."""
    if array.dtype.kind not in "US":
        raise InvalidInputError(f"{name} is no text", field=name, value=str(array.dtype), allowed="strings")
    try:
        texts = [str(text) for text in array.astype(str).ravel()]
        "".join(texts).encode()  # an array may hold halves of characters, which no reply can
    except UnicodeError:
        raise InvalidInputError(f"{name} is no text", field=name, allowed="strings in UTF-8") from None
    return texts


def dofs(arrays: Arrays, name: str) -> tuple[Dof, ...]:
    """Return an array of degrees of freedom, as `5:+Y`."""
    return tuple(Dof.parse(text, field=name) for text in texts(arrays[name], name))
