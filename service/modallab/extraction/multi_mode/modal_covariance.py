"""Covariance of modes fitted to all FRFs, from the random error of the lines."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.numerics import SUM_ROUNDING
from modallab.extraction.multi_mode.common_noise import common_noise, common_noise_covariance
from modallab.extraction.multi_mode.fit_settings import MODAL_FIT
from modallab.extraction.multi_mode.gradient_noise import GradientNoise
from modallab.extraction.multi_mode.pole_basis import PoleBasis
from modallab.extraction.multi_mode.variable_projection import (
    LinearSolution,
    ScaledLines,
)


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Covariances on the scale of the fit."""

    parameters: FloatArray
    """(n, n) covariance of all parameters, mode by mode."""
    conditional: FloatArray
    """(n_frf, n_modes, 2, 2) covariance of the coefficients of modal constants for fixed parameters."""
    sensitivity: FloatArray
    """(n_frf, n_modes, 2, n) derivatives of the coefficients by the parameters."""
    cross: FloatArray | None
    """(n_frf, n_modes, 2, n) covariance of these coefficients and the parameters; None: independent."""
    misfit: FloatArray
    """(n_frf,) mean squared residual over the variance of the lines."""
    common_noise: float
    """1, part of the variance of the lines that is common to all FRFs."""


def parameter_weights(basis: PoleBasis, linear: LinearSolution) -> FloatArray:
    """Return the weights of the slopes' columns in derivatives by parameters, (n_frf, n, n_slopes)."""
    _, n_parameters, n_slopes = basis.slope_weights.shape
    n_modes = linear.projected.shape[1] // n_slopes
    n_frf = len(linear.coefficients)
    coefficients = linear.coefficients[:, : 2 * n_modes].reshape(n_frf, n_modes, 2)
    parameter_slopes = np.einsum("jrk,kpd->jrpd", coefficients, basis.slope_weights)
    out = np.zeros((n_frf, n_modes, n_parameters, n_modes, n_slopes))
    modes = np.arange(n_modes)
    out[:, modes, :, modes] = parameter_slopes.swapaxes(0, 1)
    return out.reshape(n_frf, n_modes * n_parameters, -1)


def uncertainty(
    lines: ScaledLines, basis: PoleBasis, parameters: FloatArray, linear: LinearSolution
) -> Uncertainty:
    """Return the covariance of parameters and coefficients.

    The random error of a line is circular, and independent of other lines unless the window of the records
    correlates them. Part of it may be common to all FRFs, as the noise of a force transducer: see
    `common_noise`. The weights include neither, the covariance does. The correlation of common errors
    between a modal constant and the eigenvalues is neglected: it vanishes if weights are proportional to one
    over the squared FRFs, as they are for such noise.

    Parameters
    ----------
    lines, basis, parameters, linear
        As in the fit.
    """
    c = parameter_weights(basis, linear)
    normal = c @ linear.projected @ c.swapaxes(1, 2)
    determined = determined_parameters(normal.sum(axis=0))
    inverse = _inverse(normal.sum(axis=0), determined)
    influence = np.concatenate([-linear.mixed @ c.swapaxes(1, 2), c.swapaxes(1, 2)], axis=1)
    noise = (
        GradientNoise.of_independent_lines(normal, linear)
        if lines.noise.correlated is None
        else GradientNoise.of_correlated_lines(lines, basis, parameters, linear, influence)
    )
    misfit = _misfit(lines, linear, noise, inverse)
    misfit_factor = np.maximum(misfit, 1.0)
    # E|error|^2 is shared by two parts: half of it each
    covariance = inverse @ (0.5 * np.einsum("j,jpq->pq", misfit_factor, noise.gradient)) @ inverse
    common = common_noise(lines, basis, parameters, linear)
    if common is not None:
        by_common = common_noise_covariance(
            lines, basis, parameters, linear, influence, misfit_factor, common
        )
        covariance = covariance + inverse @ by_common @ inverse
    covariance = with_undetermined_variances(covariance, determined, parameters)
    n_modes = len(parameters)
    by_mode = (-1, n_modes, 2, parameters.size)
    sensitivity = influence[:, : 2 * n_modes].reshape(by_mode)
    modes = np.arange(n_modes)
    blocks = noise.coefficients[:, : 2 * n_modes, : 2 * n_modes].reshape(-1, n_modes, 2, n_modes, 2)
    half = 0.5 * misfit_factor[:, None, None, None]
    conditional = half * blocks[:, modes, :, modes].swapaxes(0, 1)
    cross = None if noise.cross is None else half * (noise.cross[:, : 2 * n_modes] @ inverse).reshape(by_mode)
    return Uncertainty(
        covariance, conditional, sensitivity, cross, misfit, 0.0 if common is None else common.share
    )


def determined_parameters(normal: FloatArray) -> BoolArray:
    """Return which parameters have information above its rounding, (n,).

    The normal matrix is a difference of products. Where it has a negative eigenvalue on the scale of a unit
    diagonal, its smallest entries are rounding of that size.

    Parameters
    ----------
    normal
        (n, n), symmetric.
    """
    determined = np.diag(normal) > 0
    rounding = 0.0
    while determined.any():
        rows = np.flatnonzero(determined)
        values, vectors = np.linalg.eigh(unit_diagonal(normal[np.ix_(rows, rows)])[0])
        rounding = max(rounding, min(-float(values[0]), MODAL_FIT.most_rounding))
        if values[0] > rounding - SUM_ROUNDING * len(rows):
            break
        determined[rows[np.abs(vectors[:, 0]).argmax()]] = False
    return determined


def unit_diagonal(normal: FloatArray, determined: BoolArray | None = None) -> tuple[FloatArray, FloatArray]:
    """Return a normal matrix scaled to a unit diagonal, and the lengths that its rows were divided by.

    An undetermined parameter is decoupled, with a unit diagonal entry.

    Parameters
    ----------
    determined
        (n,); None: the parameters of a positive diagonal entry, as rounding may leave none if a parameter
        depends linearly on others.
    """
    size = np.diag(normal)
    determined = size > 0 if determined is None else determined
    length = np.sqrt(np.where(determined, size, 1.0))
    normalised = np.where(np.outer(determined, determined), normal, 0.0) / np.outer(length, length)
    return np.asarray(normalised + np.diag(np.where(determined, 0.0, 1.0))), length


def with_undetermined_variances(
    covariance: FloatArray, determined: BoolArray, parameters: FloatArray
) -> FloatArray:
    """Return the covariance with a standard deviation of 100 % for parameters that no line determines.

    Parameters
    ----------
    covariance
        (n, n) of all parameters of all modes.
    determined
        (n,).
    parameters
        (n_modes, n / n_modes), the first of each mode its squared frequency, the scale of the others.
    """
    if determined.all():
        return covariance
    scale = np.repeat(np.abs(parameters[:, 0]), parameters.shape[1])
    known = np.where(np.outer(determined, determined), covariance, 0.0)
    return np.asarray(known + np.diag(np.where(determined, 0.0, scale**2)))


def _inverse(normal: FloatArray, determined: BoolArray) -> FloatArray:
    even, length = unit_diagonal(normal, determined)
    return np.asarray(np.linalg.inv(even + SUM_ROUNDING * np.eye(len(length))) / np.outer(length, length))


def _misfit(
    lines: ScaledLines, linear: LinearSolution, noise: GradientNoise, inverse: FloatArray
) -> FloatArray:
    """Return the mean square residual over the variance, (n_frf,): of as many lines as are not used up."""
    n_used = (lines.weight > 0).sum(axis=0).reshape(len(linear.misfit), -1).sum(axis=1)
    used_up = noise.unknowns + np.einsum("jpq,qp->j", noise.gradient, inverse)
    return np.asarray(linear.misfit / np.maximum(n_used - used_up / 2, 1.0))
