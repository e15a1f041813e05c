"""Effects: departures of a test from the ideal, each with its parameters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from types import NoneType
from typing import Any, ClassVar, Self

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, JsonValue
from modallab.core.parameters import Parameterised, ParameterSpec
from modallab.core.place import Channels, Dofs, EffectSpec, Members, Place
from modallab.core.registry import Family
from modallab.correlation.evidence import Evidence
from modallab.estimation.spectra import CrossSpectra
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.acquisition import Acquisition, Batch
from modallab.rig.channel import Channel
from modallab.rig.drive import Drive
from modallab.rig.local_force import LocalForce
from modallab.rig.setup import AcquisitionRun, RigSetup
from modallab.rig.source import NoiseLevels, Source


class Stage(IntEnum):
    """Place of an effect in the measuring chain; effects act in this order."""

    STRUCTURE = 1  # mass, stiffness and damping
    MOTION = 2  # a nonlinear force on the structure
    DRIVE = 3  # between source and structure
    CHANNEL = 4  # transducer and cable
    NOISE = 5  # noise of the channels
    ACQUISITION = 6  # source signal, record, range of the converter
    QUANTISATION = 7  # steps of the converter, after its range


@dataclass(frozen=True)
class Effect(Parameterised):
    """Base of all effects; its hooks do nothing.

    Hooks run in the order of `stage`; within a stage effects commute.
    """

    kind: ClassVar[str]
    summary: ClassVar[str]
    title: ClassVar[str] = ""  # its whole name in reports; empty: the words of its kind
    stage: ClassVar[Stage]
    structural: ClassVar[bool] = False  # True: it belongs to the model, else to the log book
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType,)  # what `at` may be
    at_drive: ClassVar[bool] = False  # True: a DoF it sits at can only be a drive point
    same_in_all_runs: ClassVar[bool] = False  # True: changes the structure equally in every run
    suspected: ClassVar[bool] = True  # False: a diagnosis looks for it only when told to
    intermittent: ClassVar[bool] = False  # True: its contribution is concentrated in few records
    nested_kind: ClassVar[str | None] = None  # kind with fewer parameters, a special case of this one
    of_stated_damping: ClassVar[bool] = False  # True: no suspect where the model's damping is unknown
    line_frequencies: ClassVar[tuple[float, ...]] = ()  # Hz, where it shows in single lines of spectra
    linearised_kinds: ClassVar[tuple[str, ...]] = ()  # kinds that its equivalent linearisation is of
    similar_kinds: ClassVar[tuple[str, ...]] = ()  # kinds much like it at a place that touches its own
    level_dependent: ClassVar[tuple[str, ...]] = ()  # parameters whose size goes with the source's level
    tabulated: ClassVar[bool] = False  # True: a field `table` holds a curve over frequency
    tolerance: ClassVar[str | None] = None  # name of the model tolerance that its first parameter may have
    at: Place = None

    def on_run(self, acquisition_run: AcquisitionRun) -> AcquisitionRun:
        """Before all stages: return the run with each accelerometer at its true point."""
        return acquisition_run

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        """Stage `STRUCTURE`: return the structure of this run with the effect in it."""
        return system

    def on_motion(self) -> LocalForce | None:
        """Stage `MOTION`: return the nonlinear force that the effect puts on the structure."""
        return None

    def on_drive(self, drive: Drive) -> Drive:
        """Stage `DRIVE`: return the exciter with the effect in it."""
        return drive

    def on_channel(self, channel: Channel, system: DynamicSystem) -> Channel:
        """Stage `CHANNEL`: return the channel with the effect in it."""
        return channel

    def on_noise(self, noise: NoiseLevels) -> NoiseLevels:
        """Stage `NOISE`: return the channels' noise."""
        return noise

    def on_source(self, source: Source) -> Source:
        """Stage `ACQUISITION`: return the source with the effect in it."""
        return source

    def on_spectra(self, spectra: CrossSpectra, acquisition: Acquisition) -> CrossSpectra:
        """Stages `NOISE` to `QUANTISATION`, expected route: return the spectra behind the converter.

        `spectra` may hold every few lines only: its own `freq` says which.
        """
        return spectra

    def on_records(self, batch: Batch, acquisition: Acquisition, rng: np.random.Generator) -> FloatArray:
        """Stages `NOISE` to `QUANTISATION`, sampled route: return the samples behind the converter."""
        return batch.samples

    def check(self, structure: Structure, setup: RigSetup | None = None) -> None:
        """Raise unless the effect may be at its place, in this structure and on this rig.

        Raises
        ------
        UnknownDofError
            If the structure has no such DoF.
        InvalidInputError
            If it has no such member, or an effect of this kind does not sit at such a place.
        """
        if not isinstance(self.at, self.allowed_places):
            raise self._misplaced([_PLACES[kind] for kind in self.allowed_places])
        if isinstance(self.at, Dof):
            structure.index(self.at)
            if self.at_drive and setup is not None and self.at.point not in {d.point for d in setup.drives}:
                raise self._misplaced([str(dof) for dof in setup.drives])
        elif isinstance(self.at, Dofs):
            for dof in self.at.dofs:
                structure.index(dof)
            if not self.at.dofs or len({dof.point for dof in self.at.dofs}) < len(self.at.dofs):
                raise self._misplaced("each DoF once")
        elif isinstance(self.at, Members):
            for number in self.at.numbers:
                structure.member(number)
            if len(set(self.at.numbers)) < len(self.at.numbers):
                raise self._misplaced("each member once")
        elif isinstance(self.at, Channels) and setup is not None:
            points = {dof.point for dof in setup.responses}
            if not self.at.dofs or any(dof.point not in points for dof in self.at.dofs):
                raise self._misplaced([str(dof) for dof in setup.responses])

    def _misplaced(self, allowed_places: JsonValue) -> InvalidInputError:
        place = "everywhere" if self.at is None else f"at {self.at}"
        return InvalidInputError(
            f"{self.kind} cannot be {place}", field="at", value=str(self.at), allowed=allowed_places
        )

    def added_to(self, structure: Structure) -> Structure:
        """Return the model with this effect in it."""
        return replace(structure, effects=(*structure.effects, self.spec))

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        """Return the effects of this kind that the declared hardware implies."""
        return ()

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return the possible places of the effect in a test; that of shakers is at all or at each."""
        shakers = setup.drives if cls.at_drive and setup.n_simultaneous > 1 else ()
        return (None, *(dof.point for dof in shakers))

    def scan_values(self, system: DynamicSystem, setup: RigSetup) -> Mapping[str, Sequence[float]]:
        """Return trial values by parameter, for those that depend on structure or band.

        They stand in for what the parameter itself declares.
        """
        return {}

    def equivalent(self, setup: RigSetup) -> Self | None:
        """Return the effect with other parameters that the test can hardly distinguish from it, if any."""
        return None

    def reduced_model(self) -> "tuple[Effect, tuple[str, ...]] | None":
        """Return the nested effect with fewer parameters, and the names of those that it lacks."""
        if self.nested_kind is None:
            return None
        cls = EFFECTS[self.nested_kind]
        common_parameters: dict[str, Any] = {name: self.parameters[name] for name in cls.specs()}
        extra_parameters = tuple(name for name in self.specs() if name not in common_parameters)
        return cls(at=self.at, **common_parameters), extra_parameters

    def limiting_effects(self) -> "tuple[Effect, ...]":
        """Return effects with fewer parameters that it tends to where one of its own becomes large."""
        return ()

    def smoothed(self, system: DynamicSystem, setup: RigSetup) -> "Effect":
        """Return the effect without details that simulated random errors do not depend on; here itself."""
        return self

    def fitted_specs(self) -> list[tuple[str, ParameterSpec, float]]:
        """Return name, specification and default of each parameter that a fit varies.

        An optional one that has its default keeps it; a choice is not varied.
        """
        defaults = type(self)().parameters
        return [
            (name, spec, defaults[name])
            for name, spec in self.specs().items()
            if spec.alternative is None
            and not spec.chosen
            and (spec.optional_start is None or self.parameters[name] != defaults[name])
        ]

    def variants(self, system: DynamicSystem) -> tuple[Self, ...]:
        """Return the effect with its optional parameters at the start of a fit, and with other choices."""
        defaults = type(self)().parameters
        values = {
            name: spec.optional_start
            if spec.alternative is None
            else spec.other_choice(self.parameters[name], defaults[name])
            for name, spec in self.specs().items()
        }
        extended = self.with_parameters({name: value for name, value in values.items() if value is not None})
        return () if extended == self else (extended,)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Return a prior suspicion from 0 to 1, from the residuals of the model without the effect."""
        return 0.5

    def with_parameters(self, values: dict[str, float]) -> Self:
        """Return the same effect with other parameters."""
        return replace(self, **values)  # type: ignore[arg-type]

    def acts_on(self, dof: Dof) -> bool:
        """Return whether the effect acts on a DoF or channel."""
        if isinstance(self.at, Channels):
            return dof.point in self.at.points
        if isinstance(self.at, Dofs):
            return dof.point in {each.point for each in self.at.dofs}
        return self.at is None or (isinstance(self.at, Dof) and self.at.point == dof.point)

    def acts_on_channel(self, channel: Channel) -> bool:
        """Return whether an effect on channels acts on this one.

        Everywhere means all responses: what all channels share leaves no trace in an FRF. At a DoF
        it acts on the force gauge there.
        """
        if channel.force:
            return isinstance(self.at, Dof) and self.acts_on(channel.dof)
        return not isinstance(self.at, Dof) and self.acts_on(channel.dof)

    @property
    def parameters(self) -> dict[str, float]:
        """The fitted numbers by name."""
        return {name: float(getattr(self, name)) for name in self.specs()}

    @property
    def spec(self) -> EffectSpec:
        """The effect as plain data."""
        return EffectSpec(self.kind, self.at, self.parameters, getattr(self, "table", ()))


_PLACES = {NoneType: "null", Dof: "a DoF", Dofs: "DoFs", Members: "members", Channels: "channels"}
EFFECTS: Family[type[Effect]] = Family("effect", home="modallab.effects")


def is_nonlinear(effects: Sequence[Effect]) -> bool:
    """Return whether one of some effects is a nonlinear force."""
    return any(effect.on_motion() is not None for effect in effects)


def build(spec: EffectSpec) -> Effect:
    """Return the effect of a specification.

    Raises
    ------
    InvalidInputError
        If the kind or a parameter is unknown, or a value out of bounds.
    """
    cls = EFFECTS[spec.kind]
    for name in spec.parameters:
        if name not in cls.specs():
            raise InvalidInputError(
                f"{spec.kind} has no parameter {name!r}",
                field=f"effects.{spec.kind}",
                value=name,
                allowed=list(cls.specs()),
            )
    values: dict[str, Any] = {name: float(value) for name, value in spec.parameters.items()}
    if spec.table and not cls.tabulated:
        kinds = [kind for kind, each in EFFECTS.items() if each.tabulated]
        raise InvalidInputError(
            f"{spec.kind} has no table", field="effects.table", value=f"{len(spec.table)} rows", allowed=kinds
        )
    if spec.table:
        values["table"] = spec.table
    return cls(at=spec.at, **values)
