"""Complex curve over frequency, given at some frequencies."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import make_interp_spline

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError

MAX_ROWS = 10_000
SPLINE_DEGREE = 3


@dataclass(frozen=True)
class FrequencyTable:
    """Curve through complex values: a cubic spline, beyond the first and the last frequency constant.

    Raises
    ------
    InvalidInputError
        If there is no row, or too many, if frequencies do not ascend or a number is not finite.
    """

    rows: tuple[tuple[float, float, float], ...]
    """Hz, real part and imaginary part of each row."""

    def __post_init__(self) -> None:
        numbers = np.array(self.rows, float).reshape(-1, 3)
        if not 0 < len(self.rows) <= MAX_ROWS:
            raise _refused("number of rows", len(self.rows), f"1 to {MAX_ROWS}")
        if not np.isfinite(numbers).all():
            raise _refused("numbers", "not finite", "finite numbers")
        if numbers[0, 0] < 0 or not (np.diff(numbers[:, 0]) > 0).all():
            raise _refused("frequencies", "in no ascending order", "ascending frequencies, Hz, from 0 on")

    @classmethod
    def of(cls, freq: FloatArray, values: ComplexArray) -> "FrequencyTable":
        """Return the table of values (n,) at frequencies (n,) Hz."""
        rows: Sequence[tuple[float, complex]] = list(zip(freq.tolist(), values.tolist(), strict=True))
        return cls(tuple((f, value.real, value.imag) for f, value in rows))

    @cached_property
    def _numbers(self) -> FloatArray:
        return np.array(self.rows)

    def at(self, freq: FloatArray) -> ComplexArray:
        """Return the values (n_freq,) at frequencies (n_freq,) Hz."""
        known = self._numbers
        within = np.clip(freq, known[0, 0], known[-1, 0])
        if len(known) == 1:
            return np.full(len(freq), complex(known[0, 1], known[0, 2]))
        curve = make_interp_spline(known[:, 0], known[:, 1:], min(SPLINE_DEGREE, len(known) - 1))
        parts = curve(within)
        return np.asarray(parts[:, 0] + 1j * parts[:, 1])


def _refused(what: str, value: object, allowed: str) -> InvalidInputError:
    return InvalidInputError(
        f"the {what} of a table cannot be used", field="effects.table", value=str(value), allowed=allowed
    )
