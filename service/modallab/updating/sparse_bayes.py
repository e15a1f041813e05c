"""Linear equations solved with as much prior knowledge as the data themselves call for."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.updating.settings import SPARSE_BAYES


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
    def mean_squares(self) -> FloatArray:
        """(n_blocks,) mean square of each block's values, no less than the floors'."""
        n = len(self.floors)
        square = np.bincount(self.block, self.values**2, n) / np.bincount(self.block, minlength=n)
        return np.asarray(np.maximum(square, self.floors**2))


@dataclass(frozen=True, eq=False)
class Posterior:
    """What equations and prior say together: a normal distribution, and the widths it was drawn from."""

    mean: FloatArray  # (n_params,)
    covariance: FloatArray  # (n_params, n_params)
    prior_variances: FloatArray  # (n_params,) prior variance of each; 0 of those left out
    block_variances: FloatArray  # (n_blocks,) variance of each block's rows

    @property
    def errors(self) -> FloatArray:
        """(n_params,) standard deviations."""
        return np.asarray(np.sqrt(np.maximum(np.diag(self.covariance), 0.0)))

    @property
    def is_active(self) -> BoolArray:
        """(n_params,) False of coefficients for which the data ask no width at all."""
        return self.prior_variances > 0


def sparse_bayes(
    equations: Equations, prior: Prior, prior_variances: FloatArray, block_variances: FloatArray
) -> Posterior:
    """Return the posterior of unknowns about zero, with the widths and scales of most evidence.

    Widths of the prior and variances of the blocks are those that make the data most likely with
    the unknowns integrated out, found by turns from where they start; a width that shrinks to
    nothing takes its unknown out. A block that the equations fit badly, as one of two modes that
    changed places, is weighted down. MacKay (1992), Neural Computation 4, 415-447; Tipping (2001),
    Journal of Machine Learning Research 1, 211-244.

    Parameters
    ----------
    prior_variances, block_variances
        (n_params,) and (n_blocks,) variances to start from.
    """
    least_variances = equations.floors**2
    prior_variances, block_variances = (
        np.maximum(prior_variances, SPARSE_BAYES.revived_variance),
        np.maximum(block_variances, least_variances),
    )
    for _ in range(SPARSE_BAYES.max_rounds):
        estimate = _posterior_mean(equations, prior_variances, block_variances)
        previous = np.concatenate([prior_variances, block_variances])
        block_variances = np.maximum(_block_variances(equations, estimate), least_variances)
        prior_variances = _prior_variances(prior, prior_variances, estimate)
        current = np.concatenate([prior_variances, block_variances])
        if (np.abs(current - previous) <= SPARSE_BAYES.tolerance * previous).all():
            break
    mean = _posterior_mean(equations, prior_variances, block_variances).mean
    return Posterior(
        mean,
        _posterior_covariance(equations, prior_variances, block_variances),
        prior_variances,
        block_variances,
    )


@dataclass(frozen=True, eq=False)
class _PosteriorMean:
    mean: FloatArray  # (n_params,)
    determination: (
        FloatArray  # (n_params,) share of each unknown that the data determine, the rest being the prior's
    )
    leverage: FloatArray  # (n_rows,) share of each row that fitting used up


def _whitened(
    equations: Equations, prior_variances: FloatArray, block_variances: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return rows of the unknowns kept, and right-hand sides, in units of their errors and of the prior."""
    error = np.sqrt(block_variances[equations.block])
    active = prior_variances > 0
    return equations.matrix[:, active] * np.sqrt(prior_variances[active]) / error[
        :, None
    ], equations.values / error


def _posterior_mean(
    equations: Equations, prior_variances: FloatArray, block_variances: FloatArray
) -> _PosteriorMean:
    """Return the posterior mean and how it is determined, by the smaller of two square matrices.

    In units of the prior each is 1 + something positive, by whose eigenvalues no rounding turns a
    variance negative however exact the rows are.
    """
    rows, values = _whitened(equations, prior_variances, block_variances)
    mean, determination, active = (
        np.zeros(len(prior_variances)),
        np.zeros(len(prior_variances)),
        prior_variances > 0,
    )
    if rows.shape[0] < rows.shape[1]:
        eigenvalues, eigenvectors = _nonnegative_eigh(rows @ rows.T)
        row_projection = eigenvectors.T @ rows
        mean[active] = row_projection.T @ ((eigenvectors.T @ values) / (1 + eigenvalues))
        determination[active], leverage = (
            (row_projection**2).T @ (1 / (1 + eigenvalues)),
            eigenvectors**2 @ (eigenvalues / (1 + eigenvalues)),
        )
    else:
        eigenvalues, eigenvectors = _nonnegative_eigh(rows.T @ rows)
        projected_rows = rows @ eigenvectors
        mean[active] = eigenvectors @ ((projected_rows.T @ values) / (1 + eigenvalues))
        determination[active], leverage = (
            eigenvectors**2 @ (eigenvalues / (1 + eigenvalues)),
            projected_rows**2 @ (1 / (1 + eigenvalues)),
        )
    return _PosteriorMean(mean * np.sqrt(prior_variances), determination, leverage)


def _nonnegative_eigh(square: FloatArray) -> tuple[FloatArray, FloatArray]:
    values, eigenvectors = np.linalg.eigh(square)
    return np.maximum(values, 0.0), eigenvectors


def _posterior_covariance(
    equations: Equations, prior_variances: FloatArray, block_variances: FloatArray
) -> FloatArray:
    rows, _ = _whitened(equations, prior_variances, block_variances)
    active, prior_deviation = np.flatnonzero(prior_variances), np.sqrt(prior_variances[prior_variances > 0])
    if rows.shape[0] < rows.shape[1]:
        eigenvalues, eigenvectors = _nonnegative_eigh(rows @ rows.T)
        row_projection = eigenvectors.T @ rows
        active_covariance = np.eye(len(active)) - (row_projection.T / (1 + eigenvalues)) @ row_projection
    else:
        eigenvalues, eigenvectors = _nonnegative_eigh(rows.T @ rows)
        active_covariance = (eigenvectors / (1 + eigenvalues)) @ eigenvectors.T
    covariance = np.zeros((len(prior_variances), len(prior_variances)))
    covariance[np.ix_(active, active)] = prior_deviation[:, None] * active_covariance * prior_deviation
    return covariance


def _block_variances(equations: Equations, estimate: _PosteriorMean) -> FloatArray:
    """Return the mean square that is left of each block, over the rows that fitting did not use up."""
    n = len(equations.floors)
    squared_residual = (equations.values - equations.matrix @ estimate.mean) ** 2
    count, degrees_used = (
        np.bincount(equations.block, minlength=n),
        np.bincount(equations.block, estimate.leverage, n),
    )
    return np.asarray(
        np.bincount(equations.block, squared_residual, n)
        / np.maximum(count - degrees_used, SPARSE_BAYES.min_residual_freedom * count)
    )


def _prior_variances(prior: Prior, prior_variances: FloatArray, estimate: _PosteriorMean) -> FloatArray:
    if prior is Prior.RANGE:
        return prior_variances
    mean, determination = estimate.mean, estimate.determination
    if prior is Prior.COMMON:
        common = (mean**2).sum() / max(float(determination.sum()), SPARSE_BAYES.min_determination)
        return np.full(len(determination), max(common, SPARSE_BAYES.revived_variance))
    return np.asarray(
        np.divide(
            mean**2,
            determination,
            out=np.zeros_like(determination),
            where=determination > SPARSE_BAYES.min_determination,
        )
    )
