"""Smooth curve of an unknown cause through its values at the lines."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, make_lsq_spline

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.diagnosis.unknown.settings import UNKNOWN


@dataclass(frozen=True, eq=False)
class SmoothCurve:
    """Cubic spline with at most one coefficient for every few lines."""

    real: BSpline
    """Real part over frequency, Hz."""
    imaginary: BSpline
    """Imaginary part over frequency, Hz."""
    sites: FloatArray
    """(n_coefficients,) Hz: one frequency for each coefficient."""
    error: FloatArray
    """(n_coefficients,) standard error of real and of imaginary part at the sites."""
    chi_square: float
    """Sum of squares of the deviations of the values from the curve, over their variance."""
    scatter: float
    """The same over its degrees of freedom."""

    @classmethod
    def through(cls, freq: FloatArray, z: ComplexArray, error: FloatArray) -> "SmoothCurve":
        """Return the curve by weighted least squares.

        Parameters
        ----------
        freq
            (n_freq,) Hz, ascending.
        z
            (n_freq,) values.
        error
            (n_freq,) standard error of real and of imaginary part.
        """
        n_coefficients = max(UNKNOWN.degree + 1, len(freq) // UNKNOWN.lines_per_coefficient)
        inner = np.quantile(freq, np.linspace(0, 1, n_coefficients - UNKNOWN.degree + 1)[1:-1])
        ends = np.repeat(freq[[0, -1]], UNKNOWN.degree + 1)
        knots = np.sort(np.concatenate([ends, inner]))
        real, imaginary = (
            make_lsq_spline(freq, part, knots, UNKNOWN.degree, 1 / error) for part in (z.real, z.imag)
        )
        basis = BSpline.design_matrix(freq, knots, UNKNOWN.degree).toarray() / error[:, None]
        covariance = np.linalg.pinv(basis.T @ basis)
        means = [knots[i + 1 : i + 1 + UNKNOWN.degree].mean() for i in range(n_coefficients)]
        sites = np.clip(means, freq[0], freq[-1])  # the mean of three equal numbers may be off by rounding
        at_sites = BSpline.design_matrix(sites, knots, UNKNOWN.degree).toarray()
        deviation = np.abs((z - real(freq) - 1j * imaginary(freq)) / error) ** 2
        freedom = max(2 * (len(freq) - n_coefficients), 1)
        return cls(
            real,
            imaginary,
            sites,
            np.sqrt(np.einsum("ij,jk,ik->i", at_sites, covariance, at_sites)),
            float(deviation.sum()),
            float(deviation.sum()) / freedom,
        )

    @property
    def n_parameters(self) -> int:
        """Number of real parameters."""
        return 2 * len(self.sites)

    def at(self, freq: FloatArray) -> ComplexArray:
        """Return the values at frequencies (n,) Hz; beyond the ends those at the ends."""
        within = np.clip(freq, self.sites[0], self.sites[-1])
        return np.asarray(self.real(within) + 1j * self.imaginary(within))
