"""Numbers that move along with a suspect's own in a first look: of effects accepted before, and tolerated."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.numbers.least_squares import boxed

REACH = 1.0  # that a number of an accepted effect moves by at most, on its own scale


@dataclass(frozen=True, eq=False)
class Freedom:
    """What residuals owe to numbers a little off, in straight lines, and how far these may go."""

    slopes: FloatArray  # (n_residuals, n)
    position: FloatArray  # (n,) where they are
    precision: FloatArray  # (n,) of their prior, which is about 0
    low: FloatArray  # (n,) bounds of their position
    high: FloatArray

    def __len__(self) -> int:
        return len(self.position)

    def cleared(self, vectors: FloatArray, weights: FloatArray) -> FloatArray:
        """Return residuals less what these numbers could explain.

        By least squares with their prior, whose residuals stand behind the others; what would lie beyond
        the bounds is held there.

        Parameters
        ----------
        vectors
            (..., n_residuals), weighed.
        weights
            (n_residuals,) that they were multiplied by.

        Returns
        -------
        (..., n_residuals + n).
        """
        if not len(self):
            return vectors
        slopes = weights[:, None] * self.slopes
        pull = vectors @ slopes + self.precision * self.position
        low, high = self.low - self.position, self.high - self.position
        off = boxed(slopes.T @ slopes + np.diag(self.precision), pull, low, high)
        prior = np.sqrt(self.precision) * (self.position + off)
        return np.concatenate([vectors + off @ slopes.T, prior], axis=-1)
