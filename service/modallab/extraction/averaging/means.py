"""Unweighted and weighted means with standard errors, and tests of consistency."""

from dataclasses import dataclass
from enum import Enum, auto

import numpy as np
import scipy.special

from modallab.core.arrays import FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING, SAFE_DIVISOR, UNIT_ROUNDING
from modallab.extraction.averaging.settings import MEANS


@dataclass(frozen=True)
class Mean:
    """Mean with its standard error."""

    value: float
    error: float


class Averaging(Enum):
    """Kind of average over FRFs."""

    WEIGHTED = auto()
    """Values of one structure with different standard errors; `SCATTERED` if they differ significantly."""
    PLAIN = auto()
    """Values of different structures with a known cause: unweighted mean with its standard error."""
    SCATTERED = auto()
    """Values that differ for an unknown reason: unweighted mean with the standard error of their scatter."""


def averaged(
    values: FloatArray,
    errors: FloatArray,
    neglected_error: float,
    averaging: Averaging,
    noise_correlation: float = 0.0,
) -> Mean:
    """Return the mean of values of one kind.

    Parameters
    ----------
    values, errors
        (n,) with their standard errors, n >= 1.
    neglected_error
        Part of each error that standard errors do not include.
    averaging
        Kind; values of kind `WEIGHTED` that differ significantly are treated as `SCATTERED`.
    noise_correlation
        Correlation of the errors of any two values, 0 to 1.
    """
    if averaging is Averaging.PLAIN:
        return plain_mean(values, errors, noise_correlation)
    if averaging is Averaging.WEIGHTED and not differ_significantly(
        values, np.hypot(errors, neglected_error)
    ):
        return weighted_mean(values, errors, neglected_error, noise_correlation)
    plain = plain_mean(values, errors, noise_correlation)
    scatter = float(values.std(ddof=1) / np.sqrt(len(values))) if len(values) > 1 else 0.0
    return Mean(plain.value, max(plain.error, scatter))


def is_significant(chi_square: float, degrees: int) -> bool:
    """Return whether random error alone is improbable to give such a chi-square."""
    return bool(degrees > 0 and scipy.special.chdtrc(degrees, chi_square) < MEANS.significance)


def chi_squares(values: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the chi-square about the weighted mean of each row, with all values and without the furthest.

    Parameters
    ----------
    values, weight
        (n_rows, n) with weights of one over variance, 0 where a value does not count.

    Returns
    -------
    tuple
        (n_rows,) each. Omitting value k of weight w reduces chi-square by `w d^2 W/(W - w)`, with its
        distance d from the mean of all values and the sum W of weights.
    """
    total = weight.sum(axis=1, keepdims=True)
    mean = (weight * values).sum(axis=1, keepdims=True) / np.where(total > 0, total, 1.0)
    contribution = weight * (values - mean) ** 2
    remaining_weight = total - weight
    single = remaining_weight <= PRODUCT_ROUNDING * total  # the only value with a weight
    reduction = np.where(single, contribution, contribution * total / np.where(single, 1.0, remaining_weight))
    chi_square = contribution.sum(axis=1)
    return chi_square, np.maximum(chi_square - reduction.max(axis=1, initial=0.0), 0.0)


def differ_significantly(values: FloatArray, errors: FloatArray) -> bool:
    """Return whether values differ by more than their standard errors when the furthest is left out."""
    some = errors > 0
    weight = np.where(some, 1 / np.where(some, errors, 1.0) ** 2, 0.0)
    return is_significant(float(chi_squares(values[None], weight[None])[1][0]), int(some.sum()) - 2)


def plain_mean(values: FloatArray, errors: FloatArray, noise_correlation: float = 0.0) -> Mean:
    """Return the unweighted mean of `values` (n,) with standard errors `errors` (n,), n >= 1."""
    return Mean(
        float(values.mean()), _error(np.full(len(values), 1 / len(values)), errors, noise_correlation)
    )


def weighted_mean(
    values: FloatArray, errors: FloatArray, neglected_error: float, noise_correlation: float = 0.0
) -> Mean:
    """Return the mean weighted by one over variance, with Huber weights that limit outliers.

    Parameters
    ----------
    values, errors
        (n,) with their standard errors, n >= 1.
    neglected_error
        Part of the error that standard errors do not include, equal for all values: it bounds the precision
        of a value, and with it the differences of weights.
    noise_correlation
        Correlation of the errors of any two values, 0 to 1.

    References
    ----------
    Huber, P. J. (1964), Robust estimation of a location parameter, Ann. Math. Statist. 35, 73-101.
    """
    error = np.maximum(np.hypot(errors, neglected_error), UNIT_ROUNDING * np.abs(values).max() + SAFE_DIVISOR)
    weight = 1 / (error / error.min()) ** 2
    mean = float(np.sort(values)[(len(values) - 1) // 2])
    for _ in range(MEANS.iterations):
        deviation = np.abs(values - mean) / error
        huber_weight = weight * np.minimum(
            1, MEANS.huber_threshold / np.maximum(deviation, MEANS.huber_threshold)
        )
        mean = float((huber_weight * values).sum() / huber_weight.sum())
    return Mean(mean, _error(huber_weight / huber_weight.sum(), errors, noise_correlation))


def _error(share: FloatArray, errors: FloatArray, noise_correlation: float) -> float:
    """Return the standard error of a weighted sum of values."""
    independent = ((share * errors) ** 2).sum()
    return float(
        np.sqrt((1 - noise_correlation) * independent + noise_correlation * (share * errors).sum() ** 2)
    )
