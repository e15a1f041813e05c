"""What the random error of the lines does to modes fitted to all FRFs at once."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.multi_mode.pole_basis import PoleBasis, all_columns
from modallab.extraction.multi_mode.variable_projection import (
    Linear,
    Scaled,
    below_one_another,
    columns_and_slopes,
    line_blocks,
)

BY_CHANCE = 3.0  # standard deviations
FRFS = 32  # whose influence is held at once


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Covariances on the scale of the fit."""

    parameters: FloatArray  # (n, n) of all parameters, mode by mode
    held: FloatArray  # (n_frf, n_modes, 2, 2) of each modal constant's two coefficients, the parameters held
    through: FloatArray  # (n_frf, n_modes, 2, n) how the coefficients follow the parameters
    misfit: FloatArray  # (n_frf,) mean square residual over the lines' variance
    common: float  # share of the least random error at each line that all FRFs have in common


def turned(basis: PoleBasis, linear: Linear) -> FloatArray:
    """Return how the parameters weigh the slopes' columns, (n_frf, n, n_slopes)."""
    _, n_parameters, n_slopes = basis.turn.shape
    n_modes = linear.beside.shape[1] // n_slopes
    n_frf = len(linear.coefficients)
    coefficients = linear.coefficients[:, : 2 * n_modes].reshape(n_frf, n_modes, 2)
    own = np.einsum("jrk,kpd->jrpd", coefficients, basis.turn)
    out = np.zeros((n_frf, n_modes, n_parameters, n_modes, n_slopes))
    modes = np.arange(n_modes)
    out[:, modes, :, modes] = own.swapaxes(0, 1)
    return out.reshape(n_frf, n_modes * n_parameters, -1)


def uncertainty(lines: Scaled, basis: PoleBasis, parameters: FloatArray, linear: Linear) -> Uncertainty:
    """Return the covariance of parameters and coefficients.

    The random error of a line is circular and independent of that of other lines. The FRFs may have a
    part of it in common, as the noise of a force gauge that all channels are divided by: a share of the
    least relative variance among the FRFs at that line, the share estimated from how residuals of the
    FRFs go together. Weights do not know of it; the covariance does. That a modal constant's own error
    and that of the eigenvalues are then correlated is left out: it vanishes where weights go as one
    over the square of the FRFs, as those of such noise do.

    Parameters
    ----------
    lines, basis, parameters, linear
        As of the fit.
    """
    c = turned(basis, linear)
    own = c @ linear.beside @ c.swapaxes(1, 2)
    inverse = _inverse(own.sum(axis=0))
    misfit = _misfit(lines, linear, own, inverse)
    wide = np.maximum(misfit, 1.0)
    # E|error|^2 is shared by two parts: half of it each
    covariance = inverse @ (0.5 * np.einsum("j,jpq->pq", wide, own)) @ inverse
    share = _common_share(lines, basis, parameters, linear)
    if share > 0:
        together = _together(lines, basis, parameters, linear, c, wide) * share
        covariance = covariance + inverse @ together @ inverse
    n_modes = len(parameters)
    follow = -(linear.mixed @ c.swapaxes(1, 2))[:, : 2 * n_modes]
    through = follow.reshape(-1, n_modes, 2, parameters.size)
    modes = np.arange(n_modes)
    blocks = linear.inverse[:, : 2 * n_modes, : 2 * n_modes].reshape(-1, n_modes, 2, n_modes, 2)
    held = 0.5 * wide[:, None, None, None] * blocks[:, modes, :, modes].swapaxes(0, 1)
    return Uncertainty(covariance, held, through, misfit, share)


def evened(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a normal matrix with a diagonal of ones, and the lengths that its rows were divided by.

    Of a parameter that others mimic rounding may leave less than nothing. It is told by no line: it stands
    by itself, with an error as large as the range.
    """
    size = np.diag(normal)
    told = size > 0
    length = np.sqrt(np.where(told, size, 1.0))
    even = np.where(np.outer(told, told), normal, 0.0) / np.outer(length, length)
    return np.asarray(even + np.diag(np.where(told, 0.0, 1.0))), length


def _inverse(normal: FloatArray) -> FloatArray:
    even, length = evened(normal)
    return np.asarray(np.linalg.inv(even + 1e-14 * np.eye(len(length))) / np.outer(length, length))


def _misfit(lines: Scaled, linear: Linear, own: FloatArray, inverse: FloatArray) -> FloatArray:
    """Return the mean square residual over the variance, (n_frf,): of as many lines as are not used up."""
    n_used = (lines.weight > 0).sum(axis=0).reshape(len(own), -1).sum(axis=1)
    used_up = linear.coefficients.shape[1] + np.einsum("jpq,qp->j", own, inverse)
    return np.asarray(linear.misfit / np.maximum(n_used - used_up / 2, 1.0))


def _common_share(lines: Scaled, basis: PoleBasis, parameters: FloatArray, linear: Linear) -> float:
    """Return which share of the least relative variance at a line all FRFs have in common, 0 to 1.

    Least squares over all pairs of FRFs at all lines: standardised residuals of two FRFs with relative
    variances v_i and v_j, and a common part k min(v), go together by `k min(v)/sqrt(v_i v_j)`.
    """
    if lines.response.shape[1] == lines.n_references:
        return 0.0  # of one DoF no FRF has another beside it
    together = alone = expected = alone_expected = 0.0
    of_frf = lines.mixture(basis, parameters).coefficients(linear.coefficients).T
    for block in line_blocks(len(lines.omega), 8 * lines.response.shape[1]):
        own = all_columns(basis, lines.omega[block], parameters, lines.beyond) @ of_frf
        # of several references: what the FRFs of one have in common
        fitted, response = (
            below_one_another(values, lines.n_references) for values in (own, lines.response[block])
        )
        weight = below_one_another(lines.weight[block], lines.n_references)
        exact = weight * np.abs(fitted) ** 2  # one over the relative variance
        near = np.sqrt(exact / np.maximum(exact.max(axis=1, keepdims=True), 1e-300))
        # a response's error is in proportion to the response: its phase is taken out
        turn = np.sqrt(weight) * fitted.conj() / np.maximum(np.abs(fitted), 1e-300)
        score = near * turn * (response - fitted)
        size = np.abs(score) ** 2
        together += float((np.abs(score.sum(axis=1)) ** 2 - size.sum(axis=1)).sum())
        alone += float(size.sum())
        near2 = near**2
        expected += float((near2.sum(axis=1) ** 2 - (near2**2).sum(axis=1)).sum())
        alone_expected += float(near2.sum())
    # FRFs that share nothing go together by chance, by a standard deviation of the root of `expected`
    if not (alone > 0 and expected > 0) or together < BY_CHANCE * np.sqrt(expected):
        return 0.0
    # what the fit has used up of residuals, and what they exceed their variance by, is in both sums
    return float(np.clip(together / expected * alone_expected / alone, 0.0, 1.0))


def _together(
    lines: Scaled, basis: PoleBasis, parameters: FloatArray, linear: Linear, c: FloatArray, wide: FloatArray
) -> FloatArray:
    """Return what errors common to all FRFs add to the normal matrix's covariance, for a share of 1."""
    n_parameters = c.shape[1]
    # how the parameters' influence is made of columns and slopes
    make = np.concatenate([-linear.mixed @ c.swapaxes(1, 2), c.swapaxes(1, 2)], axis=1)
    mix = lines.mixture(basis, parameters)
    of_frf = mix.coefficients(linear.coefficients).T
    influence = mix.influence(make)
    total = np.zeros((n_parameters, n_parameters))
    for block in line_blocks(len(lines.omega), 2 * FRFS * n_parameters):
        every = columns_and_slopes(lines, basis, parameters, block)
        fitted = every[:, : mix.n_each] @ of_frf
        for k, made in enumerate(influence):
            own = slice(k, None, lines.n_references)
            total += _shared(every, made, fitted[:, own], lines.weight[block, own], wide)
    return total


def _shared(
    every: ComplexArray, make: FloatArray, fitted: ComplexArray, weight: FloatArray, wide: FloatArray
) -> FloatArray:
    """Return what the FRFs of one reference add to that at some lines; `make` (n_dof, n, n_parameters)."""
    exact = weight * np.abs(fitted) ** 2
    least = np.sqrt(0.5 / np.maximum(exact.max(axis=1), 1e-300)) * (exact.max(axis=1) > 0)
    pull = weight * fitted * least[:, None] * np.sqrt(wide)
    sum_over = np.zeros((len(every), make.shape[2]), complex)
    total = np.zeros((make.shape[2], make.shape[2]))
    for start in range(0, len(make), FRFS):
        some = slice(start, start + FRFS)
        each = _influence(every, make[some]).conj() * pull[:, some, None]
        sum_over += each.sum(axis=1)
        total -= _real_square(each.reshape(-1, make.shape[2]))
    return np.asarray(total + _real_square(sum_over))


def _influence(every: ComplexArray, make: FloatArray) -> ComplexArray:
    """Return (n_lines, n_frf, n_parameters)."""
    flat = make.swapaxes(0, 1).reshape(make.shape[1], -1)
    out = every.real.copy() @ flat + 1j * (every.imag.copy() @ flat)
    return np.asarray(out.reshape(len(every), len(make), -1))


def _real_square(values: ComplexArray) -> FloatArray:
    return np.asarray(values.real.T @ values.real + values.imag.T @ values.imag)
