"""Linear equations solved with as much prior knowledge as the data themselves call for."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray, IntArray

ROUNDS = 100  # of widths and scales in turn: what then still moves moves a mean by less than its error
SETTLED = 1e-3  # relative change of every width and scale that ends the rounds
GONE = 1e-5  # share of a coefficient that data determine against its prior, below which it is left out
REVIVED = 1e-6  # width^2 with which one that was left out has another chance at the next linear equations
FEWEST = 0.2  # share of a block's rows that count as spare however many coefficients they determine


class Prior(StrEnum):
    """What is held likely of coefficients before they are measured."""

    SPARSE = "sparse"  # each has a width of its own, and most turn out to have none: few are wrong
    COMMON = "common"  # one width for all: many are a little wrong
    RANGE = "range"  # as wide as the bounds, whatever the data say


@dataclass(frozen=True, eq=False)
class Equations:
    """A (n_rows, n_params) times what is wanted is b (n_rows,), in blocks of rows alike in their errors.

    Rows are in units of their errors where these are known.
    """

    matrix: FloatArray
    values: FloatArray
    block: IntArray  # (n_rows,) which block a row is in, counted from 0
    floors: FloatArray  # (n_blocks,) least standard deviation of each block's rows


@dataclass(frozen=True, eq=False)
class Belief:
    """What equations and prior say together: a normal distribution, and the widths it was drawn from."""

    mean: FloatArray  # (n_params,)
    covariance: FloatArray  # (n_params, n_params)
    widths: FloatArray  # (n_params,) prior variance of each; 0 of those left out
    scales: FloatArray  # (n_blocks,) variance of each block's rows

    @property
    def kept(self) -> BoolArray:
        """(n_params,) False of coefficients for which the data ask no width at all."""
        return self.widths > 0


def believe(equations: Equations, prior: Prior, widths: FloatArray, scales: FloatArray) -> Belief:
    """Return the posterior of unknowns about zero, with the widths and scales of most evidence.

    Widths of the prior and variances of the blocks are those that make the data most likely with
    the unknowns integrated out, found by turns from where they start; a width that shrinks to
    nothing takes its unknown out. A block that the equations fit badly, as one of two modes that
    changed places, is weighted down. MacKay (1992), Neural Computation 4, 415-447; Tipping (2001),
    Journal of Machine Learning Research 1, 211-244.

    Parameters
    ----------
    widths, scales
        (n_params,) and (n_blocks,) variances to start from.
    """
    least = equations.floors**2
    widths, scales = np.maximum(widths, REVIVED), np.maximum(scales, least)
    for _ in range(ROUNDS):
        belief, told = _posterior(equations, widths, scales)
        before = np.concatenate([widths, scales])
        scales = np.maximum(_scales(equations, belief), least)
        widths = _widths(prior, belief, told)
        after = np.concatenate([widths, scales])
        if (np.abs(after - before) <= SETTLED * before).all():
            break
    return _posterior(equations, widths, scales)[0]


def _posterior(equations: Equations, widths: FloatArray, scales: FloatArray) -> tuple[Belief, FloatArray]:
    """Return the posterior, and the share of each unknown that the data determine."""
    kept = np.flatnonzero(widths)
    error, spread = np.sqrt(scales[equations.block]), np.sqrt(widths[kept])
    rows = equations.matrix[:, kept] * spread / error[:, None]
    # In units of the prior the matrix is 1 + something positive: regular whatever the equations are.
    inside = np.linalg.inv(np.eye(len(kept)) + rows.T @ rows)
    mean, told = np.zeros(len(widths)), np.zeros(len(widths))
    mean[kept] = spread * (inside @ (rows.T @ (equations.values / error)))
    told[kept] = 1 - np.diag(inside)
    covariance = np.zeros((len(widths), len(widths)))
    covariance[np.ix_(kept, kept)] = spread[:, None] * inside * spread
    return Belief(mean, covariance, widths, scales), told


def _scales(equations: Equations, belief: Belief) -> FloatArray:
    """Return the mean square that is left of each block, over the rows that fitting did not use up."""
    kept, n = belief.kept, len(equations.floors)
    rows = equations.matrix[:, kept]
    left = (equations.values - rows @ belief.mean[kept]) ** 2
    used = ((rows @ belief.covariance[np.ix_(kept, kept)]) * rows).sum(axis=1)
    count, spent = np.bincount(equations.block, minlength=n), np.bincount(equations.block, used, n)
    spare = np.maximum(count - spent / belief.scales, FEWEST * count)
    return np.asarray(np.bincount(equations.block, left, n) / spare)


def _widths(prior: Prior, belief: Belief, told: FloatArray) -> FloatArray:
    if prior is Prior.RANGE:
        return belief.widths
    if prior is Prior.COMMON:
        common = (belief.mean**2).sum() / max(float(told.sum()), GONE)
        return np.full(len(told), max(common, REVIVED))
    wanted = np.divide(belief.mean**2, told, out=np.zeros_like(told), where=told > GONE)
    return np.asarray(wanted)
