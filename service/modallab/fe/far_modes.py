"""Sums over modes far above a band, by Chebyshev polynomials of the squared frequency."""

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.fe.settings import FAR_MODES


class FarModes:
    """Modes whose receptances are polynomials in the band, to rounding.

    1/(lambda - omega^2) is a Chebyshev series whose terms fall by |q| = |xi - sqrt(xi^2 - 1)| each, with xi =
    2 lambda/omega_max^2 - 1 (Trefethen, Approximation Theory and Approximation Practice, 2013, chapter 3).
    All these modes together need as many columns as the series has terms.

    Parameters
    ----------
    eigenvalues
        (m,) omega_r^2 (1 + i eta_r), rad^2/s^2, all of them `are_far`.
    omega
        (n_freq,) rad/s.
    """

    def __init__(self, eigenvalues: ComplexArray, omega: FloatArray) -> None:
        square = omega**2
        top, degrees = square.max(), np.arange(FAR_MODES.terms)
        self._polynomials = np.polynomial.chebyshev.chebvander(2 * square / top - 1, degrees[-1])
        place = 2 * eigenvalues / top - 1
        root = np.sqrt(place - 1) * np.sqrt(place + 1)
        self._coefficients = (4 / (top * root))[:, None] * ((place + root)[:, None] ** -degrees)
        self._coefficients[:, 0] /= 2

    def add_to(self, alpha: ComplexArray, constants: FloatArray | ComplexArray) -> None:
        """Add the sums over these modes of modal constants (k, m) to receptances (k, n_freq), in place."""
        by_degree = constants @ self._coefficients
        parts = np.concatenate([by_degree.real, by_degree.imag]) @ self._polynomials.T
        alpha.real += parts[: len(constants)]
        alpha.imag += parts[len(constants) :]


def are_far(eigenvalues: ComplexArray, omega: FloatArray | ComplexArray) -> BoolArray:
    """Return which modes (m,) are far above a band; none where a series would not be shorter.

    None, too, at complex frequencies, as an exponential window makes them.
    """
    far = np.abs(eigenvalues) > FAR_MODES.ratio * np.max(np.abs(omega) ** 2)
    return np.asarray(far & (far.sum() > 2 * FAR_MODES.terms) & np.isrealobj(omega))
