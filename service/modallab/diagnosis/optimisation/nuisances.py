"""Nuisance parameters: deviations within tolerances that every fit estimates under a prior."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import ndtr, ndtri

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.place import Channels, Place
from modallab.diagnosis.optimisation.random_field import RandomField
from modallab.diagnosis.optimisation.settings import NUISANCE
from modallab.diagnosis.optimisation.tolerance_effects import (
    AccelerometerTolerance,
    LossTolerance,
    MemberTolerance,
)
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.rig.effect import EFFECTS, Effect

NO_FIELD = RandomField()
FIELDS = ("modulus_variation", "density_variation")
"""Tolerances that are random fields: of the stiffness and the mass of members."""
FACTORS = ("modulus", "density", "sensitivity")
"""Tolerances of factors: of two the effect is their product."""


@dataclass(frozen=True)
class Nuisance:
    """One nuisance parameter."""

    name: str
    """As in `Tolerances`."""
    standard_deviation: float
    """One standard deviation of its prior, in `unit`."""
    declared: float
    """Value that model and log book declare, in `unit`."""
    unit: str
    """s of a delay, 1 of a ratio to the declared value."""
    at: Place = None
    """Its channel; None for all."""
    mode: int | None = None
    """Elastic mode of the model, from 1; None for a parameter of no single mode."""
    shape: int | None = None
    """Shape of a random field, from 0; None for a parameter of no field."""
    logarithmic: bool = False
    """Whether the standard deviation is of the value's logarithm."""
    optional: bool = False
    """Whether only a test that shows it has it: of a mode above the band, or a shape of little variance."""

    @property
    def difference_step(self) -> float:
        """Step of a finite difference, in standard deviations."""
        if self.unit != "1":
            return NUISANCE.least_difference_step
        return max(NUISANCE.difference_step / self.standard_deviation, NUISANCE.least_difference_step)

    def value(self, position: float) -> float:
        """Return the value at a position in standard deviations."""
        if self.logarithmic:
            return float(self.declared * np.exp(self.standard_deviation * position))
        return self.declared + self.standard_deviation * position

    def slope_ratio(self, position: float) -> float:
        """Return the slope of the value at a position, over that of an additional effect's at 0.

        Additional factors multiply the value, additional loss factors and masses add to it.
        """
        slope = self.value(position) / self.declared if self.logarithmic else 1.0
        return slope / self.value(position) if self.name in FACTORS else slope

    def standard_error(self, position: float, error: float) -> float:
        """Return the standard error of the value, from that of a position in standard deviations."""
        return self.standard_deviation * error * (self.value(position) if self.logarithmic else 1.0)

    def channel_prediction(self, predicted: Predicted, observed: Observed) -> Predicted | None:
        """Return the prediction with a channel's parameter perturbed; None for one of the structure.

        The correction of the force by an acceleration is neglected: it is small.
        """
        if self.name not in ("sensitivity", "delay"):
            return None
        points = {dof.point for dof in self.at.dofs} if isinstance(self.at, Channels) else None
        acts = np.array([points is None or dof.point in points for dof in observed.outputs])
        change = self.standard_deviation * self.difference_step * acts
        if self.name == "delay":
            return replace(predicted, h=predicted.h * np.exp(-2j * np.pi * observed.freq[:, None] * change))
        gain = 1 + change
        # A free noise takes up the gain of its channel.
        noise_gain = 1.0 if observed.free_levels.response_noise else gain**2
        return replace(predicted, h=predicted.h * gain, incoherent=predicted.incoherent * noise_gain)


@dataclass(frozen=True, eq=False)
class Nuisances:
    """All nuisance parameters of a test, and their effects on it.

    A position (n,) counts standard deviations from what model and log book declare. Fits hold it by a
    prior, one residual per parameter, and within `limits`: a few prior residuals cannot
    hold against 20,000 of data. An effect of the same kind and place remains a suspect. Beside it the prior
    draws the tolerance back to the declared value, so that the effect is the whole deviation and its
    standard error holds the tolerance; without it the tolerance ends on its limit and a gap remains.
    """

    parameters: tuple[Nuisance, ...] = ()
    mass: float = 0.0
    """kg, declared mass of an accelerometer."""
    loss_factors: tuple[float, ...] = ()
    """Loss factors of the model's lowest elastic modes."""
    field: RandomField = NO_FIELD
    """Smooth deviations of the members' modulus and density."""
    damping_free: bool = False
    """Whether the model's damping is unknown."""

    def __len__(self) -> int:
        return len(self.parameters)

    @cached_property
    def limits(self) -> FloatArray:
        """(n,) largest deviations, in standard deviations.

        Of many modes or shapes the largest of all is as likely to pass its limit as a single parameter is:
        Sidak, Journal of the American Statistical Association 62 (1967), 626.
        """
        limits = np.full(len(self.parameters), NUISANCE.max_deviation)
        inside = 1 - 2 * ndtr(-NUISANCE.max_deviation)
        for name in {each.name for each in self.parameters if each.mode or each.shape is not None}:
            alike = self.indices_of(name)
            limits[alike] = -ndtri((1 - inside ** (1 / len(alike))) / 2)
        return limits

    def split(self, outputs: Sequence[Dof], held_out: BoolArray) -> tuple[IntArray, IntArray]:
        """Return the indices of parameters that fitted channels determine, and of the others.

        The others belong to held-out channels alone.
        """
        fitted = {dof.point for dof, out in zip(outputs, held_out, strict=True) if not out}
        points = {dof.point for dof in outputs} - fitted
        places = [nuisance.at for nuisance in self.parameters]
        held_out_only = [
            isinstance(at, Channels) and {dof.point for dof in at.dofs} <= points for at in places
        ]
        return np.flatnonzero(~np.array(held_out_only, bool)), np.flatnonzero(np.array(held_out_only, bool))

    def derivatives(
        self,
        predict: Callable[[Sequence[Effect]], Predicted],
        vector: Callable[[Predicted], FloatArray],
        base: Predicted,
        observed: Observed,
        position: FloatArray,
        indices: IntArray,
    ) -> FloatArray:
        """Return the derivatives (n_data, n) of residuals by the positions of some parameters.

        Parameters
        ----------
        predict
            Predictions with additional effects, which act before all others as they belong to the model.
        vector
            Residuals of a prediction.
        base
            Prediction without additional effects.
        position
            Of all parameters, in that prediction.
        indices
            (n,) indices of the parameters.
        """
        residuals = vector(base)
        columns = np.zeros((len(residuals), len(indices)))
        for i, index in enumerate(indices):
            parameter = self.parameters[index]
            step = parameter.difference_step
            perturbed = parameter.channel_prediction(base, observed)
            if perturbed is None:
                perturbed = predict(self.effects(step * (np.arange(len(self)) == index)))
            slope = parameter.slope_ratio(float(position[index])) / step
            columns[:, i] = slope * (vector(perturbed) - residuals)
        return columns

    def effects(self, position: FloatArray) -> tuple[Effect, ...]:
        """Return the effects of the parameters at a position (n,); none for those at the declared value."""
        effects: list[Effect] = []
        loss = np.zeros(len(self.loss_factors))
        for nuisance, deviation in zip(self.parameters, position, strict=True):
            value = nuisance.value(float(deviation))
            if value == nuisance.declared or nuisance.shape is not None:
                continue
            if nuisance.mode is not None:
                loss[nuisance.mode - 1] = self.loss_factors[nuisance.mode - 1] * (value - 1)
            else:
                effects.append(self._effect(nuisance, value))
        effects += self._member_deviations(position)
        return (*effects, LossTolerance(more=tuple(loss.tolist()))) if loss.any() else tuple(effects)

    def indices_of(self, name: str) -> IntArray:
        """Return the indices of the parameters of a name."""
        return np.flatnonzero(np.array([nuisance.name == name for nuisance in self.parameters], bool))

    def shapes_of(self, name: str) -> IntArray:
        """Return the shapes of the field, from 0, that the parameters of a name belong to."""
        return np.array([n.shape for n in self.parameters if n.name == name and n.shape is not None], int)

    @property
    def optional(self) -> IntArray:
        """Indices of the parameters that only a test that shows them has."""
        return np.flatnonzero(np.array([nuisance.optional for nuisance in self.parameters], bool))

    def without(self, indices: IntArray) -> "Nuisances":
        """Return the parameters without some of them, which keep their declared values."""
        omitted = set(indices.tolist())
        kept = tuple(nuisance for i, nuisance in enumerate(self.parameters) if i not in omitted)
        return replace(self, parameters=kept)

    def _member_deviations(self, position: FloatArray) -> list[Effect]:
        """Return the effect of the random fields; none where they are zero."""
        stiffness, mass = (self._member_factors(name, position) for name in FIELDS)
        return [MemberTolerance(stiffness=stiffness, mass=mass)] if stiffness or mass else []

    def _member_factors(self, name: str, position: FloatArray) -> tuple[float, ...]:
        """Return the factor of each member by a random field; none where it is zero."""
        indices = self.indices_of(name)
        if not position[indices].any():
            return ()
        deviation = self.parameters[indices[0]].standard_deviation
        logarithms = self.field.logarithms(deviation, position[indices], self.shapes_of(name))
        return tuple(np.exp(logarithms).tolist())

    def _effect(self, nuisance: Nuisance, value: float) -> Effect:
        if nuisance.name == "accelerometer_mass":
            return AccelerometerTolerance(more=self.mass * (value - 1))
        (cls,) = (cls for cls in EFFECTS.values() if cls.tolerance == nuisance.name)
        amount = next(iter(cls.specs()))
        return cls(at=nuisance.at).with_parameters({amount: value})


def split_by_scope(effects: Sequence[Effect]) -> tuple[list[Effect], list[Effect]]:
    """Return the effects on the whole structure, equal in every run, and all others."""
    scopes = [effect.structural and effect.tolerance is not None for effect in effects]
    return (
        [effect for effect, is_global in zip(effects, scopes, strict=True) if is_global],
        [effect for effect, is_global in zip(effects, scopes, strict=True) if not is_global],
    )


def draw_positions(n: int, rng: np.random.Generator) -> FloatArray:
    """Return random positions (n,) of nuisance parameters, in standard deviations.

    Normal, truncated at `NUISANCE.max_deviation`.
    """
    position = rng.standard_normal(n)
    while (outside := np.abs(position) > NUISANCE.max_deviation).any():
        position[outside] = rng.standard_normal(int(outside.sum()))
    return position
