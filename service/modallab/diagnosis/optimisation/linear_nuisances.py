"""Linear nuisance parameters beside a candidate: those of accepted effects and of tolerances."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.optimisation.bounded_quadratic import BoundedQuadratic


@dataclass(frozen=True, eq=False)
class LinearNuisances:
    """Residuals as a linear function of nuisance parameters, with their prior and bounds."""

    derivatives: FloatArray
    """(n_residuals, n) of the residuals by the parameters."""
    position: FloatArray
    """(n,) linearisation point."""
    precision: FloatArray
    """(n,) inverse variance of the prior, whose mean is 0."""
    low: FloatArray
    """(n,) lower bounds of the position."""
    high: FloatArray
    """(n,) upper bounds of the position."""

    def __len__(self) -> int:
        return len(self.position)

    def weighted(self, weights: FloatArray) -> "NuisanceProjection":
        """Return the projection of residuals that were multiplied by weights (n_residuals,)."""
        return NuisanceProjection(self, weights)


class NuisanceProjection:
    """Projects equally weighted residuals onto the complement of the nuisance parameters."""

    def __init__(self, nuisances: LinearNuisances, weights: FloatArray) -> None:
        self._nuisances = nuisances
        if len(nuisances):
            self._derivatives = weights[:, None] * nuisances.derivatives
            curvature = self._derivatives.T @ self._derivatives + np.diag(nuisances.precision)
            self._quadratic = BoundedQuadratic(curvature)

    def __call__(self, vectors: FloatArray) -> FloatArray:
        """Return residuals less the part that the nuisance parameters explain, (..., n_residuals + n).

        By least squares with the prior within the bounds; the residuals of the prior are appended.

        Parameters
        ----------
        vectors
            (..., n_residuals), weighted.
        """
        nuisances = self._nuisances
        if not len(nuisances):
            return vectors
        position, precision = nuisances.position, nuisances.precision
        gradient = vectors @ self._derivatives + precision * position
        step = self._quadratic.minimise(gradient, nuisances.low - position, nuisances.high - position)
        prior = np.sqrt(precision) * (position + step)
        return np.concatenate([vectors + step @ self._derivatives.T, prior], axis=-1)
