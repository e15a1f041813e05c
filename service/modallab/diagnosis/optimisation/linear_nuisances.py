"""Numbers that move along with a suspect's own in a first look: of effects accepted before, and tolerated."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.optimisation.least_squares import Curvature

REACH = 1.0  # that a number of an accepted effect moves by at most, on its own scale


@dataclass(frozen=True, eq=False)
class LinearNuisances:
    """What residuals owe to numbers a little off, in straight lines, and how far these may go."""

    derivatives: FloatArray  # (n_residuals, n)
    position: FloatArray  # (n,) where they are
    precision: FloatArray  # (n,) of their prior, which is about 0
    low: FloatArray  # (n,) bounds of their position
    high: FloatArray

    def __len__(self) -> int:
        return len(self.position)

    def weighted(self, weights: FloatArray) -> "NuisanceProjection":
        """Return what clears residuals that were multiplied by weights (n_residuals,)."""
        return NuisanceProjection(self, weights)


class NuisanceProjection:
    """Takes out of residuals, all weighed alike, what numbers a little off could explain."""

    def __init__(self, freedom: LinearNuisances, weights: FloatArray) -> None:
        self._freedom = freedom
        if len(freedom):
            self._slopes = weights[:, None] * freedom.derivatives
            self._curvature = Curvature(self._slopes.T @ self._slopes + np.diag(freedom.precision))

    def __call__(self, vectors: FloatArray) -> FloatArray:
        """Return residuals less what these numbers could explain.

        By least squares with their prior, whose residuals stand behind the others; what would lie beyond
        the bounds is held there.

        Parameters
        ----------
        vectors
            (..., n_residuals), weighed.

        Returns
        -------
        (..., n_residuals + n).
        """
        own = self._freedom
        if not len(own):
            return vectors
        pull = vectors @ self._slopes + own.precision * own.position
        off = self._curvature.boxed(pull, own.low - own.position, own.high - own.position)
        prior = np.sqrt(own.precision) * (own.position + off)
        return np.concatenate([vectors + off @ self._slopes.T, prior], axis=-1)
