"""Local nonlinear forces: of the displacement or velocity at one DoF."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.rig.nonlinear_settings import HERMITE


@dataclass(frozen=True, eq=False)
class LocalForce:
    """The force, N, that a part without mass puts against the motion of one DoF.

    `law` and its derivative `slope` take displacement, m, or velocity, m/s; both are vectorised and
    `law` is odd: without a mean the motion keeps none.
    """

    dof: Dof
    law: Callable[[FloatArray], FloatArray]
    slope: Callable[[FloatArray], FloatArray]
    of_velocity: bool = False
    degree: int | None = None  # where the law is a polynomial: a few points then make every mean exact

    def linearised(self, rms: float) -> "LinearisedForce":
        """Return the linearised force under a Gaussian motion of this root mean square."""
        return LinearisedForce(self, rms)

    def equivalent_coefficients(self, rms: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the equivalent stiffness or damping, and its derivative by the logarithm of the rms.

        k = E[f(s z) z]/s and dk/d ln s = E[f(s z) He_3(z)]/s, of the shape of `rms`, N/m or N s/m.
        """
        z, _ = _gaussian_quadrature(self.degree)
        first, third = _hermite_polynomials(self.degree)[:2]
        forces = self.law(rms[..., None] * z)
        return forces @ first / rms, np.sqrt(6) * (forces @ third) / rms


@dataclass(frozen=True, eq=False)
class LinearisedForce:
    """Statistical linearisation of a local force: equivalent coefficient and residual.

    Statistical linearisation: the slope k = E[f(x) x]/s^2 leaves a residual that is uncorrelated with
    the motion. Booton (1954), IRE Trans. Circuit Theory 1, 9-18; for a cubic, k = 3 k_3 s^2.
    """

    force: LocalForce
    rms: float

    @cached_property
    def _series(self) -> FloatArray:
        """a_n = E[f(s z) He_n(z)] / sqrt(n!), n = 1, 3, 5.., of a normal z, so that E[f^2] = sum a_n^2."""
        z, _ = _gaussian_quadrature(self.force.degree)
        return np.asarray(_hermite_polynomials(self.force.degree) @ self.force.law(self.rms * z))

    @cached_property
    def slope(self) -> float:
        """The equivalent stiffness, N/m, or viscous damping, N s/m."""
        return float(self.force.equivalent_coefficients(np.array(self.rms))[0]) if self.rms > 0 else 0.0

    def residual(self, x: FloatArray) -> FloatArray:
        """Return the force minus its linear part, N."""
        return np.asarray(self.force.law(x) - self.slope * x)

    def residual_correlation(self, correlation: FloatArray) -> FloatArray:
        """Return the residual's autocorrelation, N^2, from the motion's own correlation coefficient.

        sum_{n >= 3} a_n^2 rho^n over odd n, by Mehler's expansion of the two-point normal law; for a
        cubic 6 k_3^2 s^6 rho^3.
        """
        if self.force.degree is not None:
            squares = correlation * correlation
            return np.asarray(correlation * np.polynomial.polynomial.polyval(squares, self._powers))
        sines, terms = _sine_grid()
        summed = np.interp(np.abs(correlation), sines, terms @ self._powers)
        return np.asarray(np.sign(correlation) * summed)

    def residual_correlation_derivative(self, correlation: FloatArray) -> FloatArray:
        """Return the derivative of the residual's autocorrelation by the motion's, N^2 per m^2 or m^2/s^2.

        sum_{n >= 3} n a_n^2 rho^(n - 1) / s^2: what a residual moves, times this, is how the next residual
        remembers the motion itself; for a cubic 18 k_3^2 s^4 rho^2.
        """
        orders = np.arange(1, 2 * len(self._powers), 2)
        powers = self._powers * orders / self.rms**2 if self.rms > 0 else 0.0 * self._powers
        if self.force.degree is not None:
            return np.asarray(np.polynomial.polynomial.polyval(correlation * correlation, powers))
        sines, terms = _sine_grid()
        with np.errstate(
            invalid="ignore"
        ):  # at 0, where only the first power is left, of which there is none
            summed = np.where(sines > 0, (terms @ powers) / sines, 0.0)
        return np.asarray(np.interp(np.abs(correlation), sines, summed))

    @cached_property
    def _powers(self) -> FloatArray:
        """The squares of the series from the third order on."""
        powers = self._series**2
        powers[0] = 0.0
        return powers


@lru_cache(maxsize=1)
def _sine_grid() -> tuple[FloatArray, FloatArray]:
    """Return sines of angles up to a quarter turn, and their odd powers (n_angles, n_orders).

    Evenly spaced angles: where the series ends like a square root, as the arcsine does, its sum runs
    straight in the angle.
    """
    sines = np.sin(np.linspace(0.0, np.pi / 2, HERMITE.n_angles))
    return sines, sines[:, None] ** np.arange(1, HERMITE.n_orders, 2)


@lru_cache(maxsize=8)
def _gaussian_quadrature(degree: int | None) -> tuple[FloatArray, FloatArray]:
    """Return points above 0 and weights for means over a normal number of what is even."""
    if degree is not None:
        z, weights = np.polynomial.hermite_e.hermegauss(2 * (max(degree, 3) // 2 + 1))
        return z[z > 0], 2 * weights[z > 0] / weights.sum()
    z = np.linspace(0.0, HERMITE.upper_limit, HERMITE.n_points + 1)[1:]
    return z, 2 * np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi) * z[0]


@lru_cache(maxsize=8)
def _hermite_polynomials(degree: int | None) -> FloatArray:
    """Return the normalised Hermite polynomials 1, 3, 5.. times the weights of the mean, (., n_points)."""
    z, weights = _gaussian_quadrature(degree)
    terms = np.zeros((HERMITE.n_orders if degree is None else max(degree, 3) + 1, len(z)))
    terms[0], terms[1] = 1.0, z
    for n in range(2, len(terms)):
        terms[n] = (z * terms[n - 1] - np.sqrt(n - 1) * terms[n - 2]) / np.sqrt(n)
    return terms[1::2] * weights
