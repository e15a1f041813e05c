"""Relative difference of measured from predicted FRFs, unbiased at any random error."""

from typing import TYPE_CHECKING

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, logarithm
from modallab.diagnosis.residuals.settings import RESIDUAL

if TYPE_CHECKING:
    from modallab.diagnosis.residuals.observed import Observed


def normalised_difference(observed: "Observed", h: ComplexArray) -> ComplexArray:
    """Return the relative difference of a measured from a predicted H1, (n_freq, n_out).

    The difference divided by its random error has unit variance. Two forms of it are combined.

    The difference (H_m - H_p)/|H_m| over its error has mean square 1 at any coherence, and a fit to it is
    unbiased: for given G_ff, H1 is normal about its expectation and independent of G_xx (1 - coherence),
    from which its weight follows (Goodman 1963). But a fit to it has many local minima far from the
    solution. A fit to the logarithm ln(H_m/H_p) has one minimum. While the random error is small, the
    logarithm has the same distribution up to a bias: lines that are large by chance have more weight, which
    the bias of their squared error corrects. Therefore the logarithm is used where random errors are small,
    the difference where they are large, and a weighted mean of both between.

    Parameters
    ----------
    h
        (n_freq, n_out), predicted.

    Returns
    -------
    (n_freq, n_out), 0 at entries that are not usable.
    """
    ratio = observed.h / np.where(observed.usable, h, 1.0)
    weight = logarithm_weight(observed.error)
    log_ratio = logarithm(ratio) - observed.bias
    return np.where(observed.usable, weight * log_ratio + (1 - weight) * (1 - 1 / ratio), 0.0)


def logarithm_weight(error: FloatArray) -> FloatArray:
    """Return the weight of the logarithm in `normalised_difference`, 0 to 1, at a random error of |H|."""
    return np.asarray(1 / (1 + (2 * error**2 / RESIDUAL.logarithm_limit) ** 2))
