"""Fits of a model to the FRFs themselves, beside the nuisance parameters."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.diagnosis.optimisation.least_squares import BoundedGaussNewton, StepRules
from modallab.diagnosis.result import FittedParameter
from modallab.diagnosis.unknown.curve_models import CurveModel, ModelEstimate
from modallab.diagnosis.unknown.line_by_line import Influence, LineByLine
from modallab.diagnosis.unknown.settings import UNKNOWN


@dataclass(frozen=True, eq=False)
class CurveModelFit:
    """A model fitted to FRFs."""

    model: CurveModel
    """The model."""
    parameters: Mapping[str, FittedParameter]
    """Amount and shape parameters, with standard errors."""
    z: ComplexArray
    """(n_freq,) the cause by the model."""
    chi_square: float
    """Sum of squares of the whitened residuals and of the prior."""


def fit_curve_model(
    lines: LineByLine,
    influence: Influence,
    start: ModelEstimate,
    freq: FloatArray,
    *,
    offset: float,
    scale: float,
) -> CurveModelFit | None:
    """Return a model fitted to the FRFs, from an estimate; None if they do not determine its parameters.

    Parameters
    ----------
    influence
        Of the cause that follows the model.
    freq
        (n_freq,) Hz.
    offset
        What the model has more than the cause: 1 for a gain, whose cause is its change.
    scale
        Mean square of residuals that errors of the model leave; standard errors grow with its root.
    """
    task = _ModelTask(lines, influence, start, freq, offset)
    minimum = BoundedGaussNewton(task.vector, task.derivatives, task.start, task.bounds)
    minimum.minimise(StepRules(evaluations=UNKNOWN.max_steps, tolerance=UNKNOWN.tolerance))
    values = task.values(minimum.position)
    jacobian = task.derivatives(minimum.position, minimum.vector)
    size = np.sqrt((jacobian**2).sum(axis=0))
    if not (np.isfinite(size) & (size > 0)).all():
        return None
    covariance = np.linalg.pinv((jacobian / size).T @ (jacobian / size))
    n = len(values)
    errors = np.sqrt(scale * np.diag(covariance)) / size
    in_units = errors[:n] * np.concatenate([[task.amount_scale], values[1:]])
    names = [(start.model.amount, start.model.unit), *start.model.shape_units.items()]
    return CurveModelFit(
        start.model,
        {
            name: FittedParameter(float(value), float(error), unit)
            for (name, unit), value, error in zip(names, values, in_units, strict=True)
        },
        task.cause(values),
        float(minimum.vector @ minimum.vector),
    )


class _ModelTask:
    """Residuals by the parameters of a model, the amount over its start and logarithms, and nuisances."""

    def __init__(
        self, lines: LineByLine, influence: Influence, start: ModelEstimate, freq: FloatArray, offset: float
    ) -> None:
        self._lines, self._influence, self._model, self._offset = lines, influence, start.model, offset
        self._omega = 2 * np.pi * np.maximum(freq, freq[freq > 0].min())
        self.amount_scale = abs(start.amount) or 1.0
        nuisances = self._nuisances = lines.nuisances
        shapes = np.log(start.shapes)
        self._n = 1 + len(shapes)
        self.start = np.concatenate([[start.amount / self.amount_scale], shapes, np.zeros(len(nuisances))])
        reach = np.concatenate([[UNKNOWN.range_of_amounts], np.full(len(shapes), UNKNOWN.range_of_shapes)])
        model = self.start[: self._n]
        self.bounds = (
            np.concatenate([model - reach, nuisances.low - nuisances.position]),
            np.concatenate([model + reach, nuisances.high - nuisances.position]),
        )

    def values(self, u: FloatArray) -> FloatArray:
        """Return the amount and the shape parameters at a position."""
        return np.concatenate([[u[0] * self.amount_scale], np.exp(u[1 : self._n])])

    def cause(self, values: FloatArray) -> ComplexArray:
        """Return the cause (n_freq,) at an amount and shape parameters."""
        return np.asarray(values[0] * self._model.shape(values[1:], self._omega) - self._offset)

    def vector(self, u: FloatArray) -> FloatArray:
        """Return the whitened residuals, then those of the prior."""
        z, step = self.cause(self.values(u)), u[self._n :]
        residual = self._lines.residual(self._influence, z) + self._lines.slopes @ step
        prior = np.sqrt(self._nuisances.precision) * (self._nuisances.position + step)
        data = residual[self._lines.mask]
        return np.concatenate([data.real, data.imag, prior])

    def derivatives(self, u: FloatArray, _vector: FloatArray) -> FloatArray:
        """Return the derivatives of `vector`."""
        mask, z = self._lines.mask, self.cause(self.values(u))
        slope = self._lines.slope_of(self._influence, z)
        columns = [(slope * self._model_derivative(u, i)[:, None])[mask] for i in range(self._n)]
        data = np.column_stack([*columns, self._lines.slopes[mask]])
        prior = np.hstack(
            [np.zeros((len(self._nuisances), self._n)), np.diag(np.sqrt(self._nuisances.precision))]
        )
        return np.vstack([data.real, data.imag, prior])

    def _model_derivative(self, u: FloatArray, index: int) -> ComplexArray:
        step = UNKNOWN.difference_step * (np.arange(len(u)) == index)
        ahead, behind = (self.cause(self.values(u + sign * step)) for sign in (1, -1))
        return np.asarray((ahead - behind) / (2 * UNKNOWN.difference_step))
