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

    @property
    def sizes(self) -> FloatArray:
        """(n_blocks,) mean square of each block's values, no less than the floors'."""
        n = len(self.floors)
        square = np.bincount(self.block, self.values**2, n) / np.bincount(self.block, minlength=n)
        return np.asarray(np.maximum(square, self.floors**2))


@dataclass(frozen=True, eq=False)
class Posterior:
    """What equations and prior say together: a normal distribution, and the widths it was drawn from."""

    mean: FloatArray  # (n_params,)
    covariance: FloatArray  # (n_params, n_params)
    widths: FloatArray  # (n_params,) prior variance of each; 0 of those left out
    scales: FloatArray  # (n_blocks,) variance of each block's rows

    @property
    def errors(self) -> FloatArray:
        """(n_params,) standard deviations."""
        return np.asarray(np.sqrt(np.maximum(np.diag(self.covariance), 0.0)))

    @property
    def kept(self) -> BoolArray:
        """(n_params,) False of coefficients for which the data ask no width at all."""
        return self.widths > 0


def sparse_bayes(equations: Equations, prior: Prior, widths: FloatArray, scales: FloatArray) -> Posterior:
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
        solved = _solved(equations, widths, scales)
        before = np.concatenate([widths, scales])
        scales = np.maximum(_scales(equations, solved), least)
        widths = _widths(prior, widths, solved)
        after = np.concatenate([widths, scales])
        if (np.abs(after - before) <= SETTLED * before).all():
            break
    mean = _solved(equations, widths, scales).mean
    return Posterior(mean, _covariance(equations, widths, scales), widths, scales)


@dataclass(frozen=True, eq=False)
class _Solved:
    mean: FloatArray  # (n_params,)
    told: FloatArray  # (n_params,) share of each unknown that the data determine, the rest being the prior's
    used: FloatArray  # (n_rows,) share of each row that fitting used up


def _in_units(equations: Equations, widths: FloatArray, scales: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return rows of the unknowns kept, and right-hand sides, in units of their errors and of the prior."""
    error = np.sqrt(scales[equations.block])
    kept = widths > 0
    return equations.matrix[:, kept] * np.sqrt(widths[kept]) / error[:, None], equations.values / error


def _solved(equations: Equations, widths: FloatArray, scales: FloatArray) -> _Solved:
    """Return the posterior mean and how it is determined, by the smaller of two square matrices.

    In units of the prior each is 1 + something positive, by whose eigenvalues no rounding turns a
    variance negative however exact the rows are.
    """
    rows, values = _in_units(equations, widths, scales)
    mean, told, kept = np.zeros(len(widths)), np.zeros(len(widths)), widths > 0
    if rows.shape[0] < rows.shape[1]:
        data, turn = _eigen(rows @ rows.T)
        across = turn.T @ rows
        mean[kept] = across.T @ ((turn.T @ values) / (1 + data))
        told[kept], used = (across**2).T @ (1 / (1 + data)), turn**2 @ (data / (1 + data))
    else:
        data, turn = _eigen(rows.T @ rows)
        along = rows @ turn
        mean[kept] = turn @ ((along.T @ values) / (1 + data))
        told[kept], used = turn**2 @ (data / (1 + data)), along**2 @ (1 / (1 + data))
    return _Solved(mean * np.sqrt(widths), told, used)


def _eigen(square: FloatArray) -> tuple[FloatArray, FloatArray]:
    values, turn = np.linalg.eigh(square)
    return np.maximum(values, 0.0), turn


def _covariance(equations: Equations, widths: FloatArray, scales: FloatArray) -> FloatArray:
    rows, _ = _in_units(equations, widths, scales)
    kept, spread = np.flatnonzero(widths), np.sqrt(widths[widths > 0])
    if rows.shape[0] < rows.shape[1]:
        data, turn = _eigen(rows @ rows.T)
        across = turn.T @ rows
        inside = np.eye(len(kept)) - (across.T / (1 + data)) @ across
    else:
        data, turn = _eigen(rows.T @ rows)
        inside = (turn / (1 + data)) @ turn.T
    covariance = np.zeros((len(widths), len(widths)))
    covariance[np.ix_(kept, kept)] = spread[:, None] * inside * spread
    return covariance


def _scales(equations: Equations, solved: _Solved) -> FloatArray:
    """Return the mean square that is left of each block, over the rows that fitting did not use up."""
    n = len(equations.floors)
    left = (equations.values - equations.matrix @ solved.mean) ** 2
    count, spent = np.bincount(equations.block, minlength=n), np.bincount(equations.block, solved.used, n)
    return np.asarray(np.bincount(equations.block, left, n) / np.maximum(count - spent, FEWEST * count))


def _widths(prior: Prior, widths: FloatArray, solved: _Solved) -> FloatArray:
    if prior is Prior.RANGE:
        return widths
    mean, told = solved.mean, solved.told
    if prior is Prior.COMMON:
        common = (mean**2).sum() / max(float(told.sum()), GONE)
        return np.full(len(told), max(common, REVIVED))
    return np.asarray(np.divide(mean**2, told, out=np.zeros_like(told), where=told > GONE))
