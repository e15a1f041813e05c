"""Sparse Bayesian least squares: linear equations with prior variances of maximum evidence."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.updating.settings import SPARSE_BAYES


class Prior(StrEnum):
    """Prior distribution of coefficients about their nominal values."""

    SPARSE = "sparse"  # one variance a coefficient, most of which become zero: few coefficients are wrong
    COMMON = "common"  # one variance for all: many coefficients are a little wrong
    RANGE = "range"  # fixed by the bounds, independent of the data


@dataclass(frozen=True, eq=False)
class Equations:
    """Linear equations A x = b, in blocks of rows of equal variance.

    A is (n_rows, n_params), b (n_rows,). Rows are in units of their standard errors where these are known.
    """

    matrix: FloatArray
    values: FloatArray
    block: IntArray  # (n_rows,) index of the block of a row
    floors: FloatArray  # (n_blocks,) least standard deviation of a row

    @property
    def mean_squares(self) -> FloatArray:
        """(n_blocks,) mean square of b in each block, at least that of the floors."""
        n = len(self.floors)
        square = np.bincount(self.block, self.values**2, n) / np.bincount(self.block, minlength=n)
        return np.asarray(np.maximum(square, self.floors**2))


@dataclass(frozen=True, eq=False)
class Posterior:
    """Normal posterior distribution of the coefficients, with the prior and block variances behind it."""

    mean: FloatArray  # (n_params,)
    covariance: FloatArray  # (n_params, n_params)
    prior_variances: FloatArray  # (n_params,) 0 for eliminated coefficients
    block_variances: FloatArray  # (n_blocks,) of a row

    @property
    def errors(self) -> FloatArray:
        """(n_params,) standard deviations."""
        return np.asarray(np.sqrt(np.maximum(np.diag(self.covariance), 0.0)))

    @property
    def is_active(self) -> BoolArray:
        """(n_params,) False for coefficients whose prior variance became zero."""
        return self.prior_variances > 0


def sparse_bayes(
    equations: Equations, prior: Prior, prior_variances: FloatArray, block_variances: FloatArray
) -> Posterior:
    """Return the posterior of coefficients with a zero-mean normal prior, by evidence maximisation.

    Prior variances and block variances maximise the evidence, the likelihood with the coefficients integrated
    out, in alternating updates from the given start. A prior variance that shrinks to zero eliminates its
    coefficient. A block that the equations fit badly, for instance one of two modes that changed places,
    gets a large variance and little weight. MacKay (1992), Neural Computation 4, 415-447; Tipping (2001),
    Journal of Machine Learning Research 1, 211-244.

    Parameters
    ----------
    prior_variances, block_variances
        (n_params,) and (n_blocks,) initial values.
    """
    least_variances = equations.floors**2
    prior_variances = np.maximum(prior_variances, SPARSE_BAYES.revived_variance)
    block_variances = np.maximum(block_variances, least_variances)
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
    determination: FloatArray  # (n_params,) share determined by the data, 0 to 1: gamma of MacKay
    leverage: FloatArray  # (n_rows,) diagonal of the hat matrix


def _whitened(
    equations: Equations, prior_variances: FloatArray, block_variances: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return rows of active coefficients and right-hand sides, in units of their errors and the prior."""
    error = np.sqrt(block_variances[equations.block])
    active = prior_variances > 0
    rows = equations.matrix[:, active] * np.sqrt(prior_variances[active]) / error[:, None]
    return rows, equations.values / error


def _posterior_mean(
    equations: Equations, prior_variances: FloatArray, block_variances: FloatArray
) -> _PosteriorMean:
    """Return posterior mean, determination and leverage, by the smaller of the two Gram matrices.

    In units of the prior the matrix to be inverted is 1 plus a positive semidefinite one; an eigensolution
    keeps rounding from making a variance negative, however exact the rows are.
    """
    rows, values = _whitened(equations, prior_variances, block_variances)
    mean, determination = np.zeros(len(prior_variances)), np.zeros(len(prior_variances))
    active = prior_variances > 0
    if rows.shape[0] < rows.shape[1]:
        eigenvalues, eigenvectors = _nonnegative_eigh(rows @ rows.T)
        row_projection = eigenvectors.T @ rows
        mean[active] = row_projection.T @ ((eigenvectors.T @ values) / (1 + eigenvalues))
        determination[active] = (row_projection**2).T @ (1 / (1 + eigenvalues))
        leverage = eigenvectors**2 @ (eigenvalues / (1 + eigenvalues))
    else:
        eigenvalues, eigenvectors = _nonnegative_eigh(rows.T @ rows)
        projected_rows = rows @ eigenvectors
        mean[active] = eigenvectors @ ((projected_rows.T @ values) / (1 + eigenvalues))
        determination[active] = eigenvectors**2 @ (eigenvalues / (1 + eigenvalues))
        leverage = projected_rows**2 @ (1 / (1 + eigenvalues))
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
    """Return the residual mean square of each block, (n_blocks,), over its degrees of freedom."""
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
    """Return updated prior variances (n_params,): squared mean over determination."""
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
