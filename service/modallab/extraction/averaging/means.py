"""One number out of many that should be equal: plain, or weighted by standard error."""

from dataclasses import dataclass
from enum import Enum, auto

import numpy as np
import scipy.stats

from modallab.core.arrays import FloatArray

BEYOND = 2.5  # standard errors: a value so far off, one in eighty by chance, has less weight the further
ROUNDS = 20  # of reweighting; each of them is a contraction
CHANCE = 1e-3  # that random error alone shows as much


@dataclass(frozen=True)
class Mean:
    """A mean with the standard error that random error of its values gives it."""

    value: float
    error: float


class Averaging(Enum):
    """How values of several FRFs become one."""

    WEIGHTED = (
        auto()
    )  # of one structure, known better from some FRFs; scattered where they differ all the same
    PLAIN = auto()  # of as many structures, none of them truer; the error is that of the mean of these
    SCATTERED = auto()  # of structures that differ for an unknown reason; the error has their scatter


def averaged(
    values: FloatArray, errors: FloatArray, unseen: float, averaging: Averaging, shared: float = 0.0
) -> Mean:
    """Return the mean of values by one of these ways.

    Parameters
    ----------
    values, errors
        (n,) with their standard errors, n >= 1.
    unseen
        Part of each error that no standard error holds.
    averaging
        How; values that should be of one structure and differ beyond chance count as scattered.
    shared
        Correlation of the errors of any two values, 0 to 1.
    """
    if averaging is Averaging.PLAIN:
        return plain_mean(values, errors, shared)
    if averaging is Averaging.WEIGHTED and not differ(values, np.hypot(errors, unseen)):
        return weighted_mean(values, errors, unseen, shared)
    plain = plain_mean(values, errors, shared)
    scatter = float(values.std(ddof=1) / np.sqrt(len(values))) if len(values) > 1 else 0.0
    return Mean(plain.value, max(plain.error, scatter))


def beyond_chance(chi_square: float, degrees: int) -> bool:
    """Return whether random error alone would hardly show as much."""
    return bool(degrees > 0 and scipy.stats.chi2.sf(chi_square, degrees) < CHANCE)


def chi_squares(values: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return chi-square about the weighted mean of each row: of all, and without the furthest value.

    Parameters
    ----------
    values, weight
        (n_rows, n) with weights of one over variance, 0 where a value does not count.

    Returns
    -------
    tuple
        (n_rows,) each. Leaving out value k of weight w takes `w d^2 W/(W - w)` away, d being its distance
        from the mean of all and W the sum of weights.
    """
    total = weight.sum(axis=1, keepdims=True)
    mean = (weight * values).sum(axis=1, keepdims=True) / np.where(total > 0, total, 1.0)
    each = weight * (values - mean) ** 2
    left = total - weight
    alone = left <= 1e-12 * total  # the only value that counts
    taken = np.where(alone, each, each * total / np.where(alone, 1.0, left))
    whole = each.sum(axis=1)
    return whole, np.maximum(whole - taken.max(axis=1, initial=0.0), 0.0)


def differ(values: FloatArray, errors: FloatArray) -> bool:
    """Return whether values differ beyond their standard errors, the furthest of them left aside."""
    some = errors > 0
    weight = np.where(some, 1 / np.where(some, errors, 1.0) ** 2, 0.0)
    return beyond_chance(float(chi_squares(values[None], weight[None])[1][0]), int(some.sum()) - 2)


def plain_mean(values: FloatArray, errors: FloatArray, shared: float = 0.0) -> Mean:
    """Return the mean in which every value counts alike; `values`, `errors` (n,), n >= 1."""
    return Mean(float(values.mean()), _error(np.full(len(values), 1 / len(values)), errors, shared))


def weighted_mean(values: FloatArray, errors: FloatArray, unseen: float, shared: float = 0.0) -> Mean:
    """Return the mean weighted by one over variance, which no single value can drag along.

    A value that contradicts the others beyond its own standard error has its weight reduced as one over
    its distance (Huber's estimator), so that its pull is bounded.

    Parameters
    ----------
    values, errors
        (n,) with their standard errors, n >= 1.
    unseen
        Part of the error that no standard error holds, the same in all: below it agreement is no precision,
        and values are alike in weight.
    shared
        Correlation of the errors of any two values, 0 to 1.

    References
    ----------
    Huber, P. J. (1964), Robust estimation of a location parameter, Ann. Math. Statist. 35, 73-101.
    """
    error = np.maximum(np.hypot(errors, unseen), 1e-15 * np.abs(values).max() + 1e-300)
    weight = 1 / (error / error.min()) ** 2
    mean = float(np.sort(values)[(len(values) - 1) // 2])
    for _ in range(ROUNDS):
        off = np.abs(values - mean) / error
        held = weight * np.minimum(1, BEYOND / np.maximum(off, BEYOND))
        mean = float((held * values).sum() / held.sum())
    return Mean(mean, _error(held / held.sum(), errors, shared))


def _error(share: FloatArray, errors: FloatArray, shared: float) -> float:
    """Return the standard error of a sum of shares of values."""
    own = ((share * errors) ** 2).sum()
    return float(np.sqrt((1 - shared) * own + shared * (share * errors).sum() ** 2))
