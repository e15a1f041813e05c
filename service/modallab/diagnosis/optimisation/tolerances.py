"""What may differ a little and is no missing effect: numbers that every fit leaves free, held by a prior."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import ClassVar

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.parameters import parameter
from modallab.core.place import Channels, Place
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.fe.attachment import Attachment
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup

NUDGE = 1e-3  # standard deviations to differentiate by
LIMIT = 3.0  # standard deviations that nothing tolerated goes beyond
WIDEST = 0.3  # of a tolerance: three of them leave a tenth
LATEST = 3e-3  # s, of a delay


@dataclass(frozen=True)
class Tolerances:
    """One standard deviation of what may differ a little, relative, of the delay in s; 0: as declared."""

    modulus: float = 0.0  # of all members
    density: float = 0.0  # of all members
    sensitivity: float = 0.0  # of each response transducer
    accelerometer_mass: float = 0.0
    delay: float = 0.0  # of each response channel behind the force
    modal_loss_factor: float = 0.0  # of each elastic mode of the model in the band, on its own

    def __post_init__(self) -> None:
        for one in fields(self):
            value, most = getattr(self, one.name), LATEST if one.name == "delay" else WIDEST
            if not 0 <= value <= most:  # NaN fails too
                raise InvalidInputError(
                    f"the tolerance of the {one.name.replace('_', ' ')} is out of bounds",
                    field=f"tolerances.{one.name}",
                    value=value,
                    allowed=f"0 to {most:g}" + (" s" if one.name == "delay" else ""),
                )

    @classmethod
    def of(cls, values: Mapping[str, float]) -> "Tolerances":
        """Return the tolerances of plain data.

        Raises
        ------
        InvalidInputError
            If a name is unknown or a value out of bounds.
        """
        names = [one.name for one in fields(cls)]
        for name in values:
            if name not in names:
                raise InvalidInputError(
                    f"nothing that is tolerated is called {name!r}",
                    field="tolerances",
                    value=name,
                    allowed=", ".join(names),
                )
        return cls(**{name: float(value) for name, value in values.items()})


NO_TOLERANCES = Tolerances()


@dataclass(frozen=True)
class AccelerometerTolerance(Effect):
    """The accelerometers of a run are a little heavier or lighter than declared.

    Their mass is changed where it is attached already: no motion more for the Woodbury identity.
    """

    kind: ClassVar[str] = "accelerometer_tolerance"
    summary: ClassVar[str] = "accelerometers a little heavier or lighter than declared"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    more: float = parameter(0.0, unit="kg", lower=-0.5, upper=0.5, doc="mass beyond the one declared")

    def on_system(self, system: DynamicSystem, shot: AcquisitionRun) -> DynamicSystem:
        nodes = sorted({dof.node for dof in shot.outputs})
        more = system.add_masses(nodes, self.more).attachments[len(system.attachments) :]
        hung = list(system.attachments)
        places = {a.columns.tobytes(): i for i, a in reversed(list(enumerate(hung))) if _only_mass(a)}
        for own in more:
            place = places.get(own.columns.tobytes())
            if place is None:
                hung.append(own)
            else:
                hung[place] = _heavier(hung[place], own)
        return replace(system, attachments=tuple(hung))


def _only_mass(one: Attachment) -> bool:
    return one.mass is not None and one.inner == 0 and one.stiffness is one.damping is one.viscous is None


def _heavier(one: Attachment, more: Attachment) -> Attachment:
    """Return a mass with another that hangs in the same place."""
    assert one.mass is not None
    assert more.mass is not None
    return replace(one, mass=one.mass + more.mass)


@dataclass(frozen=True)
class LossTolerance(Effect):
    """Elastic modes lose a little more or less than modelled, each on its own.

    D' = D + sum (eta'_r - eta_r) lambda_r (M phi_r)(M phi_r)^T, of the modes of the model alone.
    """

    kind: ClassVar[str] = "loss_tolerance"
    summary: ClassVar[str] = "modes lose a little more or less than modelled"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    tolerance: ClassVar[str | None] = "modal_loss_factor"
    structural: ClassVar[bool] = True
    same_in_all_runs: ClassVar[bool] = True
    more: tuple[float, ...] = ()  # loss factor beyond the model's, of the lowest elastic modes

    def on_system(self, system: DynamicSystem, shot: AcquisitionRun) -> DynamicSystem:
        return system.with_modal_loss(self.more)


@dataclass(frozen=True)
class Nuisance:
    """One number that may differ a little."""

    name: str  # as `Tolerances` has it
    standard_deviation: float  # one standard deviation
    absent: float
    unit: str
    at: Place = None  # a channel of its own
    mode: int | None = None  # elastic mode of the model, from 1

    def value(self, position: float) -> float:
        """Return the number so many standard deviations from what is declared."""
        return self.absent + self.standard_deviation * position

    def channel_prediction(self, predicted: Predicted, observed: Observed) -> Predicted | None:
        """Return what a channel a little off makes of a prediction; None of a number of the structure.

        What an analyser takes out of the force by an acceleration is not followed: it is small.
        """
        if self.name not in ("sensitivity", "delay"):
            return None
        own = {dof.point for dof in self.at.dofs} if isinstance(self.at, Channels) else None
        acts = np.array([own is None or dof.point in own for dof in observed.outputs])
        off = self.standard_deviation * NUDGE * acts
        if self.name == "delay":
            return replace(predicted, h=predicted.h * np.exp(-2j * np.pi * observed.freq[:, None] * off))
        return replace(predicted, h=predicted.h * (1 + off), incoherent=predicted.incoherent * (1 + off) ** 2)


@dataclass(frozen=True, eq=False)
class Nuisances:
    """All numbers that may differ a little, and what they do to a test.

    A position (n,) counts standard deviations from what model and log book declare. Fits hold it by a
    prior, one residual a number, and within `LIMIT`: a few prior residuals cannot hold against 20,000 of
    data. An effect of the same kind and place remains a suspect. Beside it the prior draws its own
    tolerance back to what is declared, so that the effect's amount is the whole departure, and its
    standard error holds the tolerance; without it the tolerance ends on its limit and a gap is left.
    """

    parameters: tuple[Nuisance, ...] = ()
    mass: float = 0.0  # kg, of an accelerometer as declared
    loss_factors: tuple[float, ...] = ()  # of the model's elastic modes in the band

    def __len__(self) -> int:
        return len(self.parameters)

    def split(self, outputs: Sequence[Dof], held_out: BoolArray) -> tuple[IntArray, IntArray]:
        """Return which numbers fitted channels tell of, and which belong to a held-out channel alone."""
        held = {dof.point for dof, out in zip(outputs, held_out, strict=True) if out}
        own = [isinstance(n.at, Channels) and {d.point for d in n.at.dofs} <= held for n in self.parameters]
        return np.flatnonzero(~np.array(own, bool)), np.flatnonzero(np.array(own, bool))

    def derivatives(
        self,
        near: Callable[[Sequence[Effect]], Predicted],
        vector: Callable[[Predicted], FloatArray],
        base: Predicted,
        observed: Observed,
        chosen: IntArray,
    ) -> FloatArray:
        """Return the derivatives (n_data, n) of residuals by the chosen numbers' positions.

        Parameters
        ----------
        near
            Predictions with some effects more, which come before all others as they are of the model.
        vector
            Residuals of a prediction.
        base
            Without any more.
        chosen
            (n,) which of all.
        """
        here = vector(base)
        columns = np.zeros((len(here), len(chosen)))
        for i, which in enumerate(chosen):
            shown = self.parameters[which].channel_prediction(base, observed)
            if shown is None:
                shown = near(self.effects(NUDGE * (np.arange(len(self)) == which)))
            columns[:, i] = (vector(shown) - here) / NUDGE
        return columns

    def effects(self, position: FloatArray) -> tuple[Effect, ...]:
        """Return what does to a test what these numbers do; nothing for those that are as declared."""
        out: list[Effect] = []
        more = np.zeros(len(self.loss_factors))
        for one, shift in zip(self.parameters, position, strict=True):
            value = one.value(float(shift))
            if value == one.absent:
                continue
            if one.mode is not None:
                more[one.mode - 1] = self.loss_factors[one.mode - 1] * (value - 1)
            else:
                out.append(self._effect(one, value))
        return (*out, LossTolerance(more=tuple(more.tolist()))) if more.any() else tuple(out)

    def _effect(self, one: Nuisance, value: float) -> Effect:
        if one.name == "accelerometer_mass":
            return AccelerometerTolerance(more=self.mass * (value - 1))
        (cls,) = (cls for cls in EFFECTS.values() if cls.tolerance == one.name)
        amount = next(iter(cls.specs()))
        return cls(at=one.at).with_parameters({amount: value})


def split_by_scope(effects: Sequence[Effect]) -> tuple[list[Effect], list[Effect]]:
    """Return what acts on a structure as a whole, alike in every run, and all else."""
    whole = [one.structural and one.tolerance is not None for one in effects]
    return (
        [one for one, here in zip(effects, whole, strict=True) if here],
        [one for one, here in zip(effects, whole, strict=True) if not here],
    )


def nuisance_parameters(tolerances: Tolerances, system: DynamicSystem, setup: RigSetup) -> Nuisances:
    """Return the numbers of a test that may differ a little.

    One accelerometer that roves has one sensitivity and one delay; of several each has its own.

    Parameters
    ----------
    system
        The model, bare.
    """
    places: list[Place] = [None] if setup.accelerometers.roving else [Channels((d,)) for d in setup.responses]
    found: list[Nuisance] = []
    if tolerances.modulus:
        found.append(Nuisance("modulus", tolerances.modulus, 1.0, "1"))
    if tolerances.density:
        found.append(Nuisance("density", tolerances.density, 1.0, "1"))
    if tolerances.sensitivity:
        found += [Nuisance("sensitivity", tolerances.sensitivity, 1.0, "1", at) for at in places]
    if tolerances.accelerometer_mass and setup.accelerometers.mass:
        found.append(Nuisance("accelerometer_mass", tolerances.accelerometer_mass, 1.0, "1"))
    if tolerances.delay:
        found += [Nuisance("delay", tolerances.delay, 0.0, "s", at) for at in places]
    etas: tuple[float, ...] = ()
    if tolerances.modal_loss_factor:
        etas = _loss_factors(system, setup.analyser.frequency_max)
        spread = tolerances.modal_loss_factor
        modes = [i for i, eta in enumerate(etas, 1) if eta > 0]
        found += [Nuisance("modal_loss_factor", spread, 1.0, "1", mode=i) for i in modes]
    return Nuisances(tuple(found), setup.accelerometers.mass, etas)


def _loss_factors(system: DynamicSystem, top: float) -> tuple[float, ...]:
    basis = system.modes(top).elastic()
    return tuple(basis.loss_factors[basis.frequencies <= top].tolist())


def draw_positions(numbers: int, rng: np.random.Generator) -> FloatArray:
    """Return where so many numbers truly are, each drawn within its tolerance: positions (n,).

    Normal, but for what lies beyond `LIMIT` standard deviations, which is drawn again.
    """
    position = rng.standard_normal(numbers)
    while (far := np.abs(position) > LIMIT).any():
        position[far] = rng.standard_normal(int(far.sum()))
    return position
