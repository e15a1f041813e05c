"""Matrices of a model from Matrix Market files."""

import io
from typing import Any

import numpy as np
import scipy
from scipy.sparse import coo_array, csc_array

from modallab.core.errors import InvalidInputError
from modallab.fe.structure_settings import INPUT


def matrix(content: bytes, path: str, n: int) -> csc_array:
    """Return the matrix (n, n) that a file holds.

    Parameters
    ----------
    path
        What errors call the file.

    Raises
    ------
    InvalidInputError
        If it is no Matrix Market file, or its matrix is complex, not finite or of another size.
    """
    try:
        # A header may claim any size, and all of it would be made room for.
        rows, columns, _, form, *_ = scipy.io.mminfo(io.BytesIO(content))
        fits = (rows, columns) == (n, n) and (form != "array" or n**2 <= INPUT.max_element_values)
        matrix_read: Any = scipy.io.mmread(io.BytesIO(content), spmatrix=False) if fits else np.zeros((0, 0))
    # Any: its parser raises ValueError, OverflowError and others at hostile bytes.
    except Exception as error:
        raise InvalidInputError(
            f"{path} is no Matrix Market file: {error}", field=path, allowed="Matrix Market"
        ) from None
    entries = coo_array(matrix_read)
    if entries.shape != (n, n) or entries.dtype.kind not in "iuf" or not np.isfinite(entries.data).all():
        raise InvalidInputError(
            f"{path} does not fit the degrees of freedom",
            field=path,
            value=f"{rows} x {columns}, {form} of {entries.dtype}",
            allowed=f"finite real numbers, ({n}, {n})",
        )
    return csc_array(entries.astype(float))
