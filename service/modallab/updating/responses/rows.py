"""Linearised equations of measured responses, in units of their random errors."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.estimation.force_noise import decorrelated
from modallab.updating.responses.fields import Fields, ResponseModel
from modallab.updating.responses.settings import RESPONSE_PATH
from modallab.updating.responses.target import TargetResponses

Linear = tuple[ComplexArray, ComplexArray]  # rows (n_lines, n, n_params) and residuals (n_lines, n)


@dataclass(frozen=True, eq=False)
class Rows:
    """Linear equations, line by line; real and imaginary parts are rows of their own."""

    matrix: FloatArray  # (n_rows, n_params)
    residual: FloatArray  # (n_rows,)
    line: IntArray  # (n_rows,) index of the line of a row

    def blocks(self, numbers: int) -> IntArray:
        """Return the frequency band of each row (n_rows,), of at least about `numbers` rows each."""
        first = np.searchsorted(self.line, self.line)
        bands = first * max(1, len(self.line) // numbers) // len(self.line)
        return np.asarray(np.unique(bands, return_inverse=True)[1])


def log_ratios(target: TargetResponses, model: ComplexArray) -> ComplexArray:
    """Return ln(H_measured / H_model) over its random error, 0 for unused numbers, (n_lines, n_out, n_in).

    Real part (magnitude) and imaginary part (phase) have variance 1 each if only random errors are left, and
    are independent: the error that outputs share through the force counts once.
    """
    counts = target.used & (model != 0)
    ratio = np.divide(target.values, model, out=np.ones(model.shape, complex), where=counts)
    return decorrelated(np.asarray(np.log(ratio) / target.errors, complex), target.common, target.used)


def mean_square(
    residual: ComplexArray, target: TargetResponses, axis: tuple[int, ...] | None = None
) -> FloatArray:
    """Return the mean square of log ratios, 1 for random errors alone."""
    total, count = (np.abs(residual) ** 2).sum(axis=axis), target.used.sum(axis=axis)
    return np.asarray(total / np.maximum(2 * count, 1))


def log_rows(model: ResponseModel, values: FloatArray) -> Rows:
    """Return linearised log ratios at `values` (n_params,): d ln H = dH / H."""

    def linear(fields: Fields, target: TargetResponses) -> Linear:
        n_lines = len(fields.lines)
        counts = target.used & (fields.receptance != 0)
        weight = np.divide(
            1.0, fields.receptance * target.errors, out=np.zeros(counts.shape, complex), where=counts
        )
        rows = fields.derivatives(fields.driven) * weight[..., None]
        rows = decorrelated(rows, target.common[..., None], target.used[..., None])
        residual = log_ratios(target, fields.receptance)
        return rows.reshape(n_lines, -1, rows.shape[-1]), residual.reshape(n_lines, -1)

    return _stacked_rows(model, values, linear)


@dataclass(frozen=True, eq=False)
class Misfit:
    """Response residuals in directions that separate random errors from model errors.

    A wrong model leaves unbalanced forces, taken as random and independent at each line, with covariance
    w^2 k |H|^2 diag(|K_jj| + omega^2 M_jj) for a model wrong by a share w of its stiffness. The measured
    responses then scatter about the model by C = S (I + w^2 V diag(g) V^H) S, S the random errors.
    """

    residual: ComplexArray  # (n_lines, n_in, n_out) V^H S^-1 (H_measured - H_model)
    eigenvalues: FloatArray  # (n_lines, n_in, n_out) g
    projection: ComplexArray  # (n_lines, n_in, n_out, n_out) V^H S^-1
    scale: FloatArray  # (n_lines, n_in) k |H|^2, N m

    @classmethod
    def of(cls, model: ResponseModel, fields: Fields, target: TargetResponses) -> "Misfit":
        """Return the residuals of a model at the lines of its fields."""
        used, measured = target.used.swapaxes(1, 2), target.values.swapaxes(1, 2)
        least = RESPONSE_PATH.zero_response_error * target.sizes[..., None] * target.errors.swapaxes(1, 2)
        error = np.hypot(np.abs(measured) * target.errors.swapaxes(1, 2), least)
        weight = np.divide(1.0, error, out=np.zeros(error.shape), where=used)
        residual = weight * (measured - fields.receptance.swapaxes(1, 2))
        flexible = fields.to_outputs.swapaxes(1, 2)
        scatter = (flexible * fields.load[:, None]) @ flexible.conj().swapaxes(1, 2)
        scale = model.stiffness * target.sizes**2
        spread = scale[..., None, None] * scatter[:, None] * weight[..., None] * weight[..., None, :]
        # Unused responses get eigenvectors of their own, far from the others, which are left out.
        trace = np.trace(spread, axis1=2, axis2=3)[..., None].real
        diagonal = np.arange(spread.shape[-1])
        spread[..., diagonal, diagonal] -= np.where(used, 0.0, 1 + trace)
        eigenvalues, eigenvectors = np.linalg.eigh(spread)
        is_used_direction = eigenvalues > -trace / 2 - 0.5
        projection = np.where(is_used_direction[..., None], eigenvectors.conj().swapaxes(2, 3), 0.0)
        projected = (projection @ residual[..., None])[..., 0]
        return cls(projected, np.maximum(eigenvalues, 0.0), projection * weight[..., None, :], scale)


def model_error_share(model: ResponseModel, values: FloatArray) -> float:
    """Return the share w of its stiffness that explains the misfit of a model; 0 for random errors alone."""
    misfits = [Misfit.of(model, fields, model.target.at(fields.lines)) for fields in model.fields(values)]
    square = np.concatenate([np.abs(fields.residual).ravel() ** 2 for fields in misfits])
    eigenvalues = np.concatenate([fields.eigenvalues.ravel() for fields in misfits])
    numbers = model.target.n_numbers

    def excess(log: float) -> float:
        return float((square / (1 + np.exp(2 * log) * eigenvalues)).sum() - numbers)

    low, high = (float(np.log(end)) for end in RESPONSE_PATH.model_error_range)
    if excess(low) <= 0:
        return 0.0
    if excess(high) >= 0:
        return RESPONSE_PATH.model_error_range[1]
    return float(np.exp(scipy.optimize.brentq(excess, low, high)))


def reconstruction_rows(model: ResponseModel, values: FloatArray, model_error: float) -> Rows:
    """Return the equations of wavefield reconstruction at `values` (n_params,), for a given model error w.

    With C of `Misfit` the most likely motion is u = u_model + Z^-1 q, q the unbalanced forces, and the
    derivative of the model is -alpha dZ u, with the reconstructed motion of the structure in place of the
    model's own. Wavefield reconstruction inversion: van Leeuwen and Herrmann (2013), Geophysical Journal
    International 195, 661-667.
    """

    def linear(fields: Fields, target: TargetResponses) -> Linear:
        misfit = Misfit.of(model, fields, target)
        spread = 1 + model_error**2 * misfit.eigenvalues
        weighted_residual = (misfit.projection.conj().swapaxes(2, 3) @ (misfit.residual / spread)[..., None])[
            ..., 0
        ]
        forces = fields.to_outputs.conj() @ (misfit.scale[..., None] * weighted_residual).swapaxes(1, 2)
        motion = fields.driven + fields.solve(model_error**2 * fields.load[..., None] * forces)
        derivative = misfit.projection @ fields.derivatives(motion).swapaxes(1, 2)
        rows, n_lines = derivative / np.sqrt(spread)[..., None], len(fields.lines)
        residual = misfit.residual / np.sqrt(spread)
        return rows.reshape(n_lines, -1, rows.shape[-1]), residual.reshape(n_lines, -1)

    return _stacked_rows(model, values, linear)


def _stacked_rows(
    model: ResponseModel, values: FloatArray, linear: Callable[[Fields, TargetResponses], Linear]
) -> Rows:
    """Return the rows of all lines, line by line: real parts of each, then imaginary parts."""
    matrices, residuals = [], []
    for fields in model.fields(values):
        rows, residual = linear(fields, model.target.at(fields.lines))
        matrices.append(np.concatenate([rows.real, rows.imag], axis=1))
        residuals.append(np.concatenate([residual.real, residual.imag], axis=1))
    matrix, residual = np.concatenate(matrices), np.concatenate(residuals)
    line = np.repeat(np.arange(len(residual)), residual.shape[1])
    matrix, residual = matrix.reshape(-1, matrix.shape[-1]), residual.ravel()
    is_nonzero = (residual != 0) | matrix.any(axis=1)  # unused numbers are rows of zeros
    return Rows(matrix[is_nonzero], residual[is_nonzero], line[is_nonzero])
