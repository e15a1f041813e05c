"""MATLAB files of version 5 to 7 (`.mat`); those from 7.3 on are HDF5."""

import io
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import InvalidInputError, bounds
from modallab.interchange.file_content import FileContent, Piece
from modallab.interchange.format import FRF_FORMATS, FrfFormat
from modallab.interchange.reading_options import ReadingOptions
from modallab.interchange.settings import READING
from modallab.interchange.variables import content_of

_MAGIC = b"MATLAB 5.0 MAT-file"


def _read(piece: Piece, options: ReadingOptions, largest: int) -> FileContent:
    return content_of(arrays_of(piece.content, largest), options)


def arrays_of(content: bytes, largest: int) -> dict[str, NDArray[Any]]:
    """Return the arrays of numbers and text of a MATLAB file by name; of a field of a structure `test.frf`.

    Raises
    ------
    InvalidInputError
        If the file is damaged, or holds too much.
    """
    from scipy.io import loadmat

    try:
        variables = loadmat(io.BytesIO(content), verify_compressed_data_integrity=True)
        arrays = dict(_flat("", {n: v for n, v in variables.items() if not n.startswith("__")}, 0))
    except (InvalidInputError, MemoryError):
        raise
    except Exception as error:  # scipy raises a dozen kinds at damaged bytes
        raise InvalidInputError(
            f"the MATLAB file is damaged ({type(error).__name__})", field="file", allowed="MATLAB 5 to 7.3"
        ) from None
    total = sum(array.nbytes for array in arrays.values())
    if total > largest:
        raise InvalidInputError(
            "the arrays are too large", field="file", value=total, allowed=bounds(maximum=largest)
        )
    return arrays


def _flat(path: str, variables: dict[str, Any], depth: int) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield arrays of numbers and text, those of structures by their path; other variables pass by."""
    for name, value in variables.items():
        array = np.asarray(value)
        if array.dtype.names and array.size == 1 and depth < READING.max_depth:
            fields = {field: array.ravel()[0][field] for field in array.dtype.names}
            yield from _flat(f"{path}{name}.", fields, depth + 1)
        elif array.dtype.kind == "O" and array.size and not array.dtype.names:
            cells = [np.asarray(cell) for cell in array.ravel()]
            if all(cell.dtype.kind == "U" for cell in cells):
                yield f"{path}{name}", np.array(["".join(cell.ravel()) for cell in cells])
        elif array.dtype.kind in "iufcU":
            yield f"{path}{name}", array


FRF_FORMATS.register("matlab")(FrfFormat("MATLAB 5 to 7 (.mat)", lambda head: head.startswith(_MAGIC), _read))
