"""The numbers of effects as coordinates of a fit."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.parameters import ParameterSpec
from modallab.diagnosis.optimisation.least_squares import finite_difference
from modallab.rig.effect import Effect

STEP = 3e-6  # of a logarithm: far above rounding; at 1e-4 sharp resonances show their curvature
FARTHEST = 0.1  # of a logarithm, that a number which says where rather than how much is looked at aside

Residuals = Callable[[Sequence[Effect]], FloatArray]


@dataclass(frozen=True)
class FitParameter:
    """One number of one effect, fitted on a logarithmic scale, or on its own where it may be negative."""

    effect: int
    name: str
    spec: ParameterSpec
    unit: float  # of its own scale: a believable size

    @property
    def bounds(self) -> tuple[float, float]:
        """Of its position."""
        if self.spec.signed:
            return self.spec.lower / self.unit, self.spec.upper / self.unit
        low = max(self.spec.lower, 1e-12 * self.unit)  # upper bounds may lie far beyond what is believable
        return float(np.log(low)), float(np.log(self.spec.upper))

    def position(self, value: float) -> float:
        """Return where a value lies on its scale."""
        return value / self.unit if self.spec.signed else float(np.log(max(value, 1e-300)))

    def value(self, position: float) -> float:
        """Return the value at a position."""
        value = position * self.unit if self.spec.signed else np.exp(position)
        return float(np.clip(value, self.spec.lower, self.spec.upper))

    def aside(self, value: float) -> float:
        """Return a step from a value to take a difference over."""
        step = STEP * max(abs(value), 0.1 * self.unit)
        return step if value + step <= self.spec.upper else -step

    def slope(
        self, moved: Callable[[float], FloatArray], here: FloatArray, step: float, scale: float
    ) -> FloatArray:
        """Return the derivative (n_data,) of residuals by the number, `scale` being the unit of a step.

        How much of something there is acts in a nearly straight line; where something is need not.
        """
        if self.spec.absent is not None:
            return np.asarray((moved(step) - here) / step)
        return finite_difference(moved, here, step, FARTHEST * scale)

    def room(self, value: float) -> float:
        """Return how far a value lies from the nearer bound."""
        return min(value - self.spec.lower, self.spec.upper - value)


class ParameterVector:
    """The knobs of some effects, and the effects with the knobs turned."""

    def __init__(self, effects: Sequence[Effect]) -> None:
        self.effects = tuple(effects)
        self.parameters = [
            FitParameter(i, name, spec, abs(type(effect)().parameters[name]) or 1.0)
            for i, effect in enumerate(effects)
            for name, spec in effect.specs().items()
        ]
        self.low, self.high = np.array([k.bounds for k in self.parameters]).reshape(-1, 2).T
        start = np.array([k.position(effects[k.effect].parameters[k.name]) for k in self.parameters])
        self.start = start.clip(self.low, self.high)

    def __len__(self) -> int:
        return len(self.parameters)

    def with_values(self, u: FloatArray) -> list[Effect]:
        """Return the effects at a position (n_knobs,)."""
        out = list(self.effects)
        for knob, position in zip(self.parameters, u, strict=True):
            out[knob.effect] = out[knob.effect].with_parameters({knob.name: knob.value(float(position))})
        return out

    def derivatives(self, u: FloatArray, vector: Residuals, here: FloatArray) -> FloatArray:
        """Return the derivatives (n_data, n_knobs) of residuals at a position (n_knobs,).

        Parameters
        ----------
        vector
            Residuals of the effects turned.
        here
            Those at the position.
        """
        out = np.zeros((len(here), len(u)))
        for i, (knob, step) in enumerate(zip(self.parameters, self._aside(u), strict=True)):
            out[:, i] = knob.slope(partial(self._moved, vector, u, i), here, step, 1.0)
        return out

    def physical_derivatives(self, vector: Residuals, here: FloatArray) -> FloatArray:
        """Return the derivatives (n_data, n_knobs) of residuals by each number on its own scale."""
        out = np.zeros((len(here), len(self)))
        for i, (knob, value) in enumerate(zip(self.parameters, self.values(), strict=True)):
            step = knob.aside(value)
            out[:, i] = knob.slope(partial(self._changed, vector, i), here, step, abs(step) / STEP)
        return out

    def perturbed(self, u: FloatArray) -> list[tuple[list[Effect], float]]:
        """Return the effects with each knob in turn a little aside of a position, and by how much."""
        return [(self.with_values(_shifted(u, i, step)), step) for i, step in enumerate(self._aside(u))]

    def _aside(self, u: FloatArray) -> list[float]:
        return [STEP if one + STEP < high else -STEP for one, high in zip(u, self.high, strict=True)]

    def _moved(self, vector: Residuals, u: FloatArray, which: int, step: float) -> FloatArray:
        return vector(self.with_values(_shifted(u, which, step)))

    def _changed(self, vector: Residuals, which: int, step: float) -> FloatArray:
        knob, effects = self.parameters[which], list(self.effects)
        value = self.values()[which] + step
        effects[knob.effect] = effects[knob.effect].with_parameters(
            {knob.name: float(np.clip(value, knob.spec.lower, knob.spec.upper))}
        )
        return vector(effects)

    def values(self) -> list[float]:
        """Return the numbers as they are."""
        return [self.effects[k.effect].parameters[k.name] for k in self.parameters]


def _shifted(u: FloatArray, which: int, step: float) -> FloatArray:
    return np.asarray(u + step * (np.arange(len(u)) == which))
