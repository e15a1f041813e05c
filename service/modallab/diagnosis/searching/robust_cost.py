"""Robust cost of a candidate on coarse predictions."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.residuals.residual import inflation_weights
from modallab.diagnosis.searching.scan_settings import LOSS


class RobustCost:
    """Cauchy loss of residuals at every noise inflation, nuisance parameters projected out first."""

    def __init__(self, prediction: CoarsePrediction) -> None:
        observed = prediction.observed
        self._project_out = prediction.project_out
        self._weights = [inflation_weights(observed, observed.fitted, w) for w in LOSS.noise_inflations]

    def project_out(self, vectors: FloatArray) -> FloatArray:
        """Return residuals of unit variance without nuisances; see `CoarsePrediction.project_out`."""
        return self._project_out(vectors, 0.0)

    def of(self, vectors: FloatArray) -> FloatArray:
        """Return the cost (..., n_inflations) of residuals (..., n_residuals) of unit variance."""
        inflations = zip(self._weights, LOSS.noise_inflations, strict=True)
        squares = [self._project_out(vectors * weights, w) ** 2 for weights, w in inflations]
        return np.stack([cauchy_loss(square) for square in squares], axis=-1)


def cauchy_loss(squares: FloatArray) -> FloatArray:
    """Return the Cauchy loss (...): the sum of c ln(1 + s / c) over squares s of the last axis."""
    length, factors = LOSS.product_length, squares / LOSS.cauchy_scale
    factors += 1
    n = factors.shape[-1] // length
    product = factors[..., :n].copy()
    for i in range(1, length):
        product *= factors[..., i * n : (i + 1) * n]
    remainder = np.log(factors[..., length * n :]).sum(axis=-1)
    return np.asarray(LOSS.cauchy_scale * (np.log(product).sum(axis=-1) + remainder))


def line_minimum_fraction(start: FloatArray, end: FloatArray) -> float:
    """Return the fraction of the way from one residual vector to another at which the square is least.

    1 at the end; 0 where the square rises from the start.
    """
    direction = end - start
    square = float(direction @ direction)
    return max(0.0, -float(direction @ start) / square) if square > 0 else 0.0
