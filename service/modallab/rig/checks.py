"""Rules of good practice for a rig."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import ClassVar, Protocol

from modallab.core.arrays import FloatArray
from modallab.fe.assembly import assemble
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.accelerometer_check import accelerometer_checks
from modallab.rig.effect import EFFECTS, build
from modallab.rig.settings import CHECK
from modallab.rig.setup import AcquisitionRun, RigSetup
from modallab.rig.stinger_check import stinger_checks


class Check(Protocol):
    """Figures of one rule, and whether it is fulfilled."""

    name: ClassVar[str]
    rule: ClassVar[str]

    @property
    def fulfilled(self) -> bool:
        """Whether the rule is kept."""
        ...


@dataclass(frozen=True)
class SuspensionCheck:
    """Ratio of the highest rigid-body frequency to the first elastic one."""

    name: ClassVar[str] = "suspension"
    rule: ClassVar[str] = "the highest rigid-body frequency is under 10 % of the first elastic one"
    highest_rigid_frequency: float
    """Hz, highest rigid-body frequency on the suspension; 0 without one."""
    first_elastic_frequency: float
    """Hz, first elastic natural frequency on the suspension."""
    ratio: float
    """1, the first over the second."""

    @property
    def fulfilled(self) -> bool:
        """Whether the structure is as good as free."""
        return self.ratio < CHECK.rigid_elastic_ratio


def suspension_check(structure: Structure, setup: RigSetup) -> SuspensionCheck:
    """Return the rigid-body and elastic frequencies of a structure on its suspension.

    Rigid-body modes are as many as the structure has without the suspension, and the lowest with it.
    Ewins, Modal Testing (2000), chapter 3.

    Raises
    ------
    UnknownDofError
        If the structure lacks a DoF that a band holds.
    """
    system = assemble(structure)
    everywhere = AcquisitionRun(setup.drives, setup.responses)
    for effect in [build(spec) for spec in structure.effects]:
        system = effect.on_system(system, everywhere)
    free = system.modes().n_rigid_body
    declared = [build(spec) for spec in setup.effects if spec.kind == "suspension"]
    for band in [*EFFECTS["suspension"].from_setup(setup), *declared]:
        band.check(structure, setup)
        system = band.on_system(system, everywhere)
    frequencies = _lowest(system, free + 1)
    highest, elastic = float(frequencies[free - 1]) if free else 0.0, float(frequencies[free])
    return SuspensionCheck(highest, elastic, highest / elastic)


def _lowest(system: DynamicSystem, count: int) -> FloatArray:
    # A large structure is solved up to a frequency, not for a number: widen until there are enough.
    limit = CHECK.initial_frequency
    while len(frequencies := system.modes(limit).frequencies) < count:
        limit *= CHECK.frequency_step
    return frequencies


CHECKS: tuple[Callable[[Structure, RigSetup], Check], ...] = (suspension_check,)


def checks(structure: Structure, setup: RigSetup) -> tuple[Check, ...]:
    """Return all checks that the declaration of a rig allows."""
    general_checks = (check(structure, setup) for check in CHECKS)
    return (*general_checks, *stinger_checks(setup), *accelerometer_checks(setup))


@dataclass(frozen=True)
class CheckResult:
    """Rule of good practice, evaluated for a rig on a structure."""

    name: str
    """Name of the check."""
    rule: str
    """Rule in words."""
    fulfilled: bool
    """Whether the rule is kept."""
    figures: Mapping[str, float]
    """SI units, figures that the rule compares, by name."""


def check_result(check: Check) -> CheckResult:
    """Return the result of a check, its figures by name."""
    figures = {field.name: getattr(check, field.name) for field in fields(check)}  # type: ignore[arg-type]
    return CheckResult(check.name, check.rule, check.fulfilled, figures)
