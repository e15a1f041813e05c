"""A force within the structure that is no straight line: at one motion, of its displacement or velocity."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof

ORDERS = 200  # of the Hermite series that is kept: 2 % of the residual power of dry friction lies beyond
FARTHEST, POINTS = 9.0, 4001  # of the quadrature behind it: a normal density ends to rounding there


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

    def at(self, rms: float) -> "Linearised":
        """Return what the force is to a Gaussian motion of this root mean square."""
        return Linearised(self, rms)


@dataclass(frozen=True, eq=False)
class Linearised:
    """A local force under a Gaussian motion: its best straight line, and what that leaves.

    Statistical linearisation: the slope k = E[f(x) x]/s^2 leaves a residual that is uncorrelated with
    the motion. Booton (1954), IRE Trans. Circuit Theory 1, 9-18; for a cubic, k = 3 k_3 s^2.
    """

    force: LocalForce
    rms: float

    @cached_property
    def _series(self) -> FloatArray:
        """(ORDERS,) a_n = E[f(s z) He_n(z)] / sqrt(n!) of a normal z, so that E[f^2] = sum a_n^2."""
        z, _ = _normal()
        return np.asarray(_polynomials() @ self.force.law(self.rms * z))

    @cached_property
    def slope(self) -> float:
        """The equivalent stiffness, N/m, or viscous damping, N s/m."""
        z, weights = _normal()
        return float((weights * z) @ self.force.law(self.rms * z) / self.rms) if self.rms > 0 else 0.0

    def residual(self, x: FloatArray) -> FloatArray:
        """Return the force less its straight line, N."""
        return np.asarray(self.force.law(x) - self.slope * x)

    def residual_slope(self, x: FloatArray) -> FloatArray:
        """Return the derivative of `residual`."""
        return np.asarray(self.force.slope(x) - self.slope)

    def residual_correlation(self, correlation: FloatArray) -> FloatArray:
        """Return the residual's autocorrelation, N^2, from the motion's own correlation coefficient.

        sum_{n >= 2} a_n^2 rho^n, by Mehler's expansion of the two-point normal law; for a cubic
        6 k_3^2 s^6 rho^3.
        """
        powers = self._series**2
        powers[:2] = 0.0
        return np.asarray(np.polynomial.polynomial.polyval(correlation, powers))


@lru_cache(maxsize=1)
def _normal() -> tuple[FloatArray, FloatArray]:
    """Return points and weights for means over a normal number."""
    z = np.linspace(-FARTHEST, FARTHEST, POINTS)
    return z, np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi) * (z[1] - z[0])


@lru_cache(maxsize=1)
def _polynomials() -> FloatArray:
    """Return the normalised Hermite polynomials times the weights of the mean, (ORDERS, POINTS)."""
    z, weights = _normal()
    terms = np.zeros((ORDERS, POINTS))
    terms[0], terms[1] = 1.0, z
    for n in range(2, ORDERS):
        terms[n] = (z * terms[n - 1] - np.sqrt(n - 1) * terms[n - 2]) / np.sqrt(n)
    return terms * weights
