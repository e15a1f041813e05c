"""Covariance of modes fitted to all FRFs, from the random error of the lines."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import SAFE_DIVISOR, SUM_ROUNDING
from modallab.extraction.multi_mode.pole_basis import PoleBasis, all_columns
from modallab.extraction.multi_mode.settings import MODAL_COVARIANCE
from modallab.extraction.multi_mode.variable_projection import (
    LinearSolution,
    ScaledLines,
    columns_and_slopes,
    line_blocks,
    stack_references,
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
    misfit: FloatArray
    """(n_frf,) mean squared residual over the variance of the lines."""
    common_noise: float
    """1, part of the smallest relative variance at each line that is common to all FRFs."""


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

    The random error of a line is circular and independent of other lines. Part of it may be common to all
    FRFs, as the noise of a force transducer: a part of the least relative variance among the FRFs at the
    line, estimated from the correlation of the residuals of FRFs. The weights do not include it, the
    covariance does. The correlation of this error between a modal constant and the eigenvalues is neglected:
    it vanishes if weights are proportional to one over the squared FRFs, as they are for such noise.

    Parameters
    ----------
    lines, basis, parameters, linear
        As in the fit.
    """
    c = parameter_weights(basis, linear)
    normal = c @ linear.projected @ c.swapaxes(1, 2)
    inverse = _inverse(normal.sum(axis=0))
    misfit = _misfit(lines, linear, normal, inverse)
    misfit_factor = np.maximum(misfit, 1.0)
    # E|error|^2 is shared by two parts: half of it each
    covariance = inverse @ (0.5 * np.einsum("j,jpq->pq", misfit_factor, normal)) @ inverse
    share = _shared_noise_fraction(lines, basis, parameters, linear)
    if share > 0:
        common_covariance = (
            _common_noise_covariance(lines, basis, parameters, linear, c, misfit_factor) * share
        )
        covariance = covariance + inverse @ common_covariance @ inverse
    n_modes = len(parameters)
    follow = -(linear.mixed @ c.swapaxes(1, 2))[:, : 2 * n_modes]
    sensitivity = follow.reshape(-1, n_modes, 2, parameters.size)
    modes = np.arange(n_modes)
    blocks = linear.inverse[:, : 2 * n_modes, : 2 * n_modes].reshape(-1, n_modes, 2, n_modes, 2)
    conditional = 0.5 * misfit_factor[:, None, None, None] * blocks[:, modes, :, modes].swapaxes(0, 1)
    return Uncertainty(covariance, conditional, sensitivity, misfit, share)


def unit_diagonal(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a normal matrix scaled to a unit diagonal, and the lengths that its rows were divided by.

    Rounding may leave a diagonal entry without a positive value if a parameter depends linearly on others.
    Such a parameter is decoupled, with a unit diagonal entry.
    """
    size = np.diag(normal)
    determined = size > 0
    length = np.sqrt(np.where(determined, size, 1.0))
    normalised = np.where(np.outer(determined, determined), normal, 0.0) / np.outer(length, length)
    return np.asarray(normalised + np.diag(np.where(determined, 0.0, 1.0))), length


def _inverse(normal: FloatArray) -> FloatArray:
    even, length = unit_diagonal(normal)
    return np.asarray(np.linalg.inv(even + SUM_ROUNDING * np.eye(len(length))) / np.outer(length, length))


def _misfit(
    lines: ScaledLines, linear: LinearSolution, normal: FloatArray, inverse: FloatArray
) -> FloatArray:
    """Return the mean square residual over the variance, (n_frf,): of as many lines as are not used up."""
    n_used = (lines.weight > 0).sum(axis=0).reshape(len(normal), -1).sum(axis=1)
    used_up = linear.coefficients.shape[1] + np.einsum("jpq,qp->j", normal, inverse)
    return np.asarray(linear.misfit / np.maximum(n_used - used_up / 2, 1.0))


def _shared_noise_fraction(
    lines: ScaledLines, basis: PoleBasis, parameters: FloatArray, linear: LinearSolution
) -> float:
    """Return the part, 0 to 1, of the least relative variance at a line that is common to all FRFs.

    Least squares over all pairs of FRFs at all lines: standardised residuals of two FRFs with relative
    variances v_i and v_j, and a common part k min(v), have the correlation `k min(v)/sqrt(v_i v_j)`.
    """
    if lines.response.shape[1] == lines.n_references:
        return 0.0  # one DoF has no second FRF of the same reference
    cross_power = power = expected = expected_power = 0.0
    of_frf = lines.reference_mixing(basis, parameters).coefficients(linear.coefficients).T
    for block in line_blocks(len(lines.omega), 8 * lines.response.shape[1]):
        frf_response = all_columns(basis, lines.omega[block], parameters, lines.fixed_poles) @ of_frf
        # with several references, errors are common to the FRFs of one reference
        fitted, response = (
            stack_references(values, lines.n_references) for values in (frf_response, lines.response[block])
        )
        weight = stack_references(lines.weight[block], lines.n_references)
        exact = weight * np.abs(fitted) ** 2  # one over the relative variance
        near = np.sqrt(exact / np.maximum(exact.max(axis=1, keepdims=True), SAFE_DIVISOR))
        # errors are proportional to the response, so that its phase is removed
        turn = np.sqrt(weight) * fitted.conj() / np.maximum(np.abs(fitted), SAFE_DIVISOR)
        score = near * turn * (response - fitted)
        size = np.abs(score) ** 2
        cross_power += float((np.abs(score.sum(axis=1)) ** 2 - size.sum(axis=1)).sum())
        power += float(size.sum())
        near2 = near**2
        expected += float((near2.sum(axis=1) ** 2 - (near2**2).sum(axis=1)).sum())
        expected_power += float(near2.sum())
    # without common errors, the sum has a standard deviation of the square root of `expected`
    if not (power > 0 and expected > 0) or cross_power < MODAL_COVARIANCE.common_noise_deviations * np.sqrt(
        expected
    ):
        return 0.0
    # degrees of freedom used by the fit, and a misfit above 1, affect both sums alike
    return float(np.clip(cross_power / expected * expected_power / power, 0.0, 1.0))


def _common_noise_covariance(
    lines: ScaledLines,
    basis: PoleBasis,
    parameters: FloatArray,
    linear: LinearSolution,
    c: FloatArray,
    wide: FloatArray,
) -> FloatArray:
    """Return the contribution of fully common errors to the covariance of the gradient, (n, n)."""
    n_parameters = c.shape[1]
    # the influence of lines on the parameters as a combination of columns and slopes
    make = np.concatenate([-linear.mixed @ c.swapaxes(1, 2), c.swapaxes(1, 2)], axis=1)
    mix = lines.reference_mixing(basis, parameters)
    of_frf = mix.coefficients(linear.coefficients).T
    influence = mix.influence(make)
    total = np.zeros((n_parameters, n_parameters))
    for block in line_blocks(len(lines.omega), 2 * MODAL_COVARIANCE.frfs_in_memory * n_parameters):
        basis_columns = columns_and_slopes(lines, basis, parameters, block)
        fitted = basis_columns[:, : mix.n_frf_columns] @ of_frf
        for k, reference_influence in enumerate(influence):
            reference_frfs = slice(k, None, lines.n_references)
            total += _reference_covariance(
                basis_columns,
                reference_influence,
                fitted[:, reference_frfs],
                lines.weight[block, reference_frfs],
                wide,
            )
    return total


def _reference_covariance(
    basis_columns: ComplexArray, make: FloatArray, fitted: ComplexArray, weight: FloatArray, wide: FloatArray
) -> FloatArray:
    """Return that contribution of one reference at a block of lines; `make` (n_dof, n, n_parameters)."""
    exact = weight * np.abs(fitted) ** 2
    least = np.sqrt(0.5 / np.maximum(exact.max(axis=1), SAFE_DIVISOR)) * (exact.max(axis=1) > 0)
    pull = weight * fitted * least[:, None] * np.sqrt(wide)
    sum_over = np.zeros((len(basis_columns), make.shape[2]), complex)
    total = np.zeros((make.shape[2], make.shape[2]))
    for start in range(0, len(make), MODAL_COVARIANCE.frfs_in_memory):
        block = slice(start, start + MODAL_COVARIANCE.frfs_in_memory)
        frf_influence = _influence(basis_columns, make[block]).conj() * pull[:, block, None]
        sum_over += frf_influence.sum(axis=1)
        total -= _real_square(frf_influence.reshape(-1, make.shape[2]))
    return np.asarray(total + _real_square(sum_over))


def _influence(basis_columns: ComplexArray, make: FloatArray) -> ComplexArray:
    """Return the influence of each line on the parameters, (n_lines, n_frf, n_parameters)."""
    flat = make.swapaxes(0, 1).reshape(make.shape[1], -1)
    out = basis_columns.real.copy() @ flat + 1j * (basis_columns.imag.copy() @ flat)
    return np.asarray(out.reshape(len(basis_columns), len(make), -1))


def _real_square(values: ComplexArray) -> FloatArray:
    return np.asarray(values.real.T @ values.real + values.imag.T @ values.imag)
