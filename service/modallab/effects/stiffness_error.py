"""Stiffness error of members."""

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


@EFFECTS.register("stiffness_error")
@dataclass(frozen=True)
class StiffnessError(Effect):
    """Wrong stiffness: the stiffness matrix of some members, or of all, is a multiple of that in the model.

    K' = K + (factor - 1) sum K_e over these members; stiffness-proportional damping changes with it. To
    first order the relative increase of omega^2 is (factor - 1) times their share of the strain energy of
    the mode: Rayleigh, The Theory of Sound (1894), chapter IV.
    """

    kind: ClassVar[str] = "stiffness_error"
    summary: ClassVar[str] = "members stiffer or softer than modelled"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    tolerance: ClassVar[str | None] = "modulus"
    structural: ClassVar[bool] = True
    similar_kinds: ClassVar[tuple[str, ...]] = ("joint_flexibility",)
    same_in_all_runs: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Members)
    factor: float = parameter(
        1.5, unit="1", lower=0.05, upper=20.0, absent=1.0, doc="true stiffness over the model's"
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        if isinstance(self.at, Members):
            for number in self.at.numbers:
                system = system.change_member(number, axial=self.factor - 1, bending=self.factor - 1)
            return system
        return system.scaled(stiffness=self.factor)

    def added_to(self, structure: Structure) -> Structure:
        """Return the model with the members' stiffness corrected."""
        wrong = self.at.numbers if isinstance(self.at, Members) else [m.number for m in structure.all_members]
        members = (
            replace(
                m, axial_factor=m.axial_factor * self.factor, bending_factor=m.bending_factor * self.factor
            )
            if m.number in wrong
            else m
            for m in structure.all_members
        )
        return structure.of_members(members)

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        table = system.members
        return (None, *(Members((number,)) for number in table.numbers)) if table else (None,)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Frequencies shift; a stiffer member raises them."""
        return 0.5 + 0.3 * evidence.rising
