"""What a first look at a hypothesis leaves unexplained, as one number."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.residuals.residual import inflation_weights

NOISE_INFLATIONS = (0.0, 0.03, 0.3)  # from residuals of the size of noise to modes that sit elsewhere
TOGETHER = 4  # numbers whose logarithms are taken as one of their product, which does not overflow yet
HEAVY_TAIL = 9.0  # squared residual beyond which a line only says "wrong", not how wrong


class Costs:
    """Saturating sums of squares of residuals, at every widening of their random errors.

    What could be explained by numbers that are a little off, within their tolerances, is taken out first.
    """

    def __init__(self, glimpses: CoarsePrediction) -> None:
        observed = glimpses.observed
        self._cleared = glimpses.project_out
        self._weights = [inflation_weights(observed, observed.fitted, widen) for widen in NOISE_INFLATIONS]

    def project_out(self, vectors: FloatArray) -> FloatArray:
        """Return residuals of unit variance without nuisances; see `CoarsePrediction.project_out`."""
        return self._cleared(vectors, 0.0)

    def of(self, vectors: FloatArray) -> FloatArray:
        """Return the cost (..., n_widenings) of residuals (..., n_residuals) of unit variance."""
        looks = zip(self._weights, NOISE_INFLATIONS, strict=True)
        squares = [self._cleared(vectors * weights, widen) ** 2 for weights, widen in looks]
        return np.stack([cauchy_loss(one) for one in squares], axis=-1)


def cauchy_loss(squares: FloatArray) -> FloatArray:
    """Return sums (...) of HEAVY_TAIL ln(1 + s / HEAVY_TAIL) over the last axis."""
    factors = squares / HEAVY_TAIL
    factors += 1
    n = factors.shape[-1] // TOGETHER
    product = factors[..., :n].copy()
    for i in range(1, TOGETHER):
        product *= factors[..., i * n : (i + 1) * n]
    rest = np.log(factors[..., TOGETHER * n :]).sum(axis=-1)
    return np.asarray(HEAVY_TAIL * (np.log(product).sum(axis=-1) + rest))


def line_minimum_fraction(start: FloatArray, moved: FloatArray) -> float:
    """Return how far the line from one vector to another falls, 1 at the other; 0 where it rises."""
    slope = moved - start
    along = float(slope @ slope)
    return max(0.0, -float(slope @ start) / along) if along > 0 else 0.0
