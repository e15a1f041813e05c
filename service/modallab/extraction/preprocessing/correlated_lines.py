"""Lines whose random errors are correlated by the window of the records."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.fft

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.estimation.error_correlation import ErrorCorrelation
from modallab.extraction.preprocessing.settings import CORRELATED_LINES


@dataclass(frozen=True, eq=False)
class CorrelatedLines:
    """Lines of a range with the correlation of their errors.

    The window of the records makes the errors of lines the transform of noise whose power changes over the
    record. Sums over lines are therefore sums over instants in which errors are independent.
    """

    place: IntArray
    """(n_lines,) position of each line, in lines, ascending from 0."""
    power: FloatArray
    """(n_instants,) power of the noise at instants of a record, of sum 1."""

    @classmethod
    def of(cls, freq: FloatArray, correlation: ErrorCorrelation) -> Self:
        """Return lines at frequencies.

        Parameters
        ----------
        freq
            (n_lines,) Hz, ascending, at multiples of one over the length of the records.
        correlation
            Of the errors of lines by the window of the records.
        """
        place = line_numbers(freq)
        # a transform is periodic: the last lines correlate with the first as lines farther apart do
        n = scipy.fft.next_fast_len(int(place[-1]) + 1 + CORRELATED_LINES.farthest)
        return cls(place, correlation.power(n))

    @property
    def squared_correlation(self) -> float:
        """Sum of the squared moduli of the correlations of a line with all lines, itself included."""
        return len(self.power) * float(self.power @ self.power)

    def independent(self, values: ComplexArray) -> ComplexArray:
        """Return the values (n, n_lines) as combinations of independent errors, (n, n_instants).

        With errors e of lines of unit variance, the covariance of `sum_k conj(a_k) e_k` and the same sum for
        b is `sum_t conj(a_t) b_t` of the combinations returned for a and b.
        """
        spread = np.zeros((len(values), len(self.power)), complex)
        spread[:, self.place] = values
        combined = scipy.fft.ifft(spread, axis=1, overwrite_x=True)
        combined *= len(self.power) * np.sqrt(self.power)
        return np.asarray(combined)


def line_numbers(freq: FloatArray) -> IntArray:
    """Return the positions of frequencies in lines, (..., n_lines), from 0 at the first.

    Parameters
    ----------
    freq
        (..., n_lines) Hz, ascending, mostly in neighbouring lines.
    """
    spacing = np.median(np.diff(freq))
    return np.asarray(np.rint((freq - freq[..., :1]) / spacing).astype(np.int64))
