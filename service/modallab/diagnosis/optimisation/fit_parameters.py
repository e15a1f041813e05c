"""The parameters of effects as coordinates of a fit."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.core.parameters import ParameterSpec
from modallab.diagnosis.optimisation.least_squares import finite_difference
from modallab.diagnosis.optimisation.settings import DIFFERENCE
from modallab.rig.effect import Effect

EffectResiduals = Callable[[Sequence[Effect]], FloatArray]


@dataclass(frozen=True)
class FitParameter:
    """One parameter of one effect, on a logarithmic axis, or over its scale where it may be negative."""

    effect: int
    """Index of its effect."""
    name: str
    """Name of the parameter."""
    spec: ParameterSpec
    """Bounds, unit and neutral value."""
    scale: float
    """Typical magnitude, in the parameter's unit."""

    @property
    def bounds(self) -> tuple[float, float]:
        """The bounds of its coordinate."""
        if self.spec.signed:
            return self.spec.lower / self.scale, self.spec.upper / self.scale
        low = max(self.spec.lower, DIFFERENCE.lower_bound * self.scale)
        return float(np.log(low)), float(np.log(self.spec.upper))

    def position(self, value: float) -> float:
        """Return the coordinate of a value."""
        return value / self.scale if self.spec.signed else float(np.log(max(value, SAFE_DIVISOR)))

    def value(self, position: float) -> float:
        """Return the value at a coordinate, within its bounds."""
        value = position * self.scale if self.spec.signed else np.exp(position)
        return float(np.clip(value, self.spec.lower, self.spec.upper))

    def difference_step(self, value: float) -> float:
        """Return the step of a finite difference at a value, in the parameter's unit."""
        step = DIFFERENCE.step * max(abs(value), DIFFERENCE.min_value * self.scale)
        return step if value + step <= self.spec.upper else -step

    def derivative(
        self, shifted: Callable[[float], FloatArray], base: FloatArray, step: float, scale: float
    ) -> FloatArray:
        """Return the derivative (n_data,) of residuals by the parameter.

        Residuals are nearly linear in an amount; in a place or a shape they need not be.

        Parameters
        ----------
        shifted
            Residuals at a shift of the parameter.
        base
            Residuals without a shift.
        step
            Small step, with sign.
        scale
            Unit of the step: 1 on the fitted axis.
        """
        if self.spec.absent is not None:
            return np.asarray((shifted(step) - base) / step)
        return finite_difference(shifted, base, step, DIFFERENCE.max_step * scale)

    def distance_to_bound(self, value: float) -> float:
        """Return the distance of a value to the nearer bound, in the parameter's unit."""
        return min(value - self.spec.lower, self.spec.upper - value)


class ParameterVector:
    """The parameters of several effects as one vector of coordinates; optional ones where not at default.

    Parameters
    ----------
    largest_ratio
        Largest ratio by which positive parameters of intermittent effects may change.
    """

    def __init__(self, effects: Sequence[Effect], largest_ratio: float = np.inf) -> None:
        self.effects = tuple(effects)
        self.parameters = [
            FitParameter(i, name, spec, abs(default) or 1.0)
            for i, effect in enumerate(effects)
            for name, spec, default in effect.fitted_specs()
        ]
        self.low, self.high = np.array([p.bounds for p in self.parameters]).reshape(-1, 2).T
        start = np.array([p.position(effects[p.effect].parameters[p.name]) for p in self.parameters])
        self.start = start.clip(self.low, self.high)
        limited = [effects[p.effect].intermittent and not p.spec.signed for p in self.parameters]
        reach = np.where(limited, np.log(largest_ratio), np.inf)
        self.low, self.high = (
            np.maximum(self.low, self.start - reach),
            np.minimum(self.high, self.start + reach),
        )

    def __len__(self) -> int:
        return len(self.parameters)

    def with_values(self, u: FloatArray) -> list[Effect]:
        """Return the effects at coordinates (n_parameters,)."""
        out = list(self.effects)
        for parameter, position in zip(self.parameters, u, strict=True):
            value = parameter.value(float(position))
            out[parameter.effect] = out[parameter.effect].with_parameters({parameter.name: value})
        return out

    def derivatives(self, u: FloatArray, vector: EffectResiduals, base: FloatArray) -> FloatArray:
        """Return the derivatives (n_data, n_parameters) of residuals by the coordinates.

        Parameters
        ----------
        u
            (n_parameters,) coordinates.
        vector
            Residuals of effects.
        base
            Residuals at the coordinates.
        """
        out = np.zeros((len(base), len(u)))
        for i, (parameter, step) in enumerate(zip(self.parameters, self._steps(u), strict=True)):
            out[:, i] = parameter.derivative(partial(self._at_coordinate, vector, u, i), base, step, 1.0)
        return out

    def physical_derivatives(self, vector: EffectResiduals, base: FloatArray) -> FloatArray:
        """Return the derivatives (n_data, n_parameters) of residuals by the parameters in their units."""
        out = np.zeros((len(base), len(self)))
        for i, (parameter, value) in enumerate(zip(self.parameters, self.values(), strict=True)):
            step = parameter.difference_step(value)
            scale = abs(step) / DIFFERENCE.step
            out[:, i] = parameter.derivative(partial(self._at_value, vector, i), base, step, scale)
        return out

    def perturbed(self, u: FloatArray) -> list[tuple[list[Effect], float]]:
        """Return the effects with one coordinate after the other perturbed, and the perturbation."""
        return [(self.with_values(_shifted(u, i, step)), step) for i, step in enumerate(self._steps(u))]

    def _steps(self, u: FloatArray) -> list[float]:
        step = DIFFERENCE.step
        return [step if x + step < high else -step for x, high in zip(u, self.high, strict=True)]

    def _at_coordinate(self, vector: EffectResiduals, u: FloatArray, index: int, step: float) -> FloatArray:
        return vector(self.with_values(_shifted(u, index, step)))

    def _at_value(self, vector: EffectResiduals, index: int, step: float) -> FloatArray:
        parameter, effects = self.parameters[index], list(self.effects)
        value = self.values()[index] + step
        effects[parameter.effect] = effects[parameter.effect].with_parameters(
            {parameter.name: float(np.clip(value, parameter.spec.lower, parameter.spec.upper))}
        )
        return vector(effects)

    def values(self) -> list[float]:
        """Return the values of the parameters, each in its unit."""
        return [self.effects[p.effect].parameters[p.name] for p in self.parameters]


def _shifted(u: FloatArray, index: int, step: float) -> FloatArray:
    return np.asarray(u + step * (np.arange(len(u)) == index))
