"""Density error of members."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar

from modallab.core.parameters import parameter
from modallab.core.place import Members, Place
from modallab.correlation.evidence import Evidence
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("density_error")
@dataclass(frozen=True)
class DensityError(Effect):
    """Wrong density: the mass matrix of some members, or of all, is a multiple of that in the model.

    M' = M + (factor - 1) sum M_e over these members. To first order the relative decrease of omega^2 is
    (factor - 1) times their share of the kinetic energy of the mode: Rayleigh, The Theory of Sound (1894),
    chapter IV.
    """

    kind: ClassVar[str] = "density_error"
    summary: ClassVar[str] = "members heavier or lighter than modelled"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    tolerance: ClassVar[str | None] = "density"
    structural: ClassVar[bool] = True
    similar_kinds: ClassVar[tuple[str, ...]] = ("extra_mass",)
    same_in_all_runs: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Members)
    factor: float = parameter(
        1.5, unit="1", lower=0.05, upper=20.0, absent=1.0, doc="true density over the model's"
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        if isinstance(self.at, Members):
            for number in self.at.numbers:
                system = system.change_member(number, mass=self.factor - 1)
            return system
        return system.scaled(mass=self.factor)

    def added_to(self, structure: Structure) -> Structure:
        """Return the model with the members' mass corrected."""
        wrong = self.at.numbers if isinstance(self.at, Members) else [m.number for m in structure.all_members]
        members = (
            replace(m, mass_factor=m.mass_factor * self.factor) if m.number in wrong else m
            for m in structure.all_members
        )
        return structure.of_members(members)

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        table = system.members
        return (None, *(Members((number,)) for number in table.numbers)) if table else (None,)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Frequencies shift; a heavier member lowers them."""
        return 0.5 + 0.3 * evidence.falling
