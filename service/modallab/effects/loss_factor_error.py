"""Loss factor error of members."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar

from modallab.core.parameters import parameter
from modallab.core.place import Members, Place
from modallab.correlation.evidence import Evidence
from modallab.fe.alteration import Alteration
from modallab.fe.damping import ModalDamping, StructuralDamping
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("loss_factor_error")
@dataclass(frozen=True)
class LossFactorError(Effect):
    """Wrong loss factor: the stiffness-proportional damping of some members, or of all, is a multiple.

    D_e = factor eta K_e, as the damping coefficients c_i of the 1992 thesis, equation 6.2; the part b K_e of
    viscous damping is multiplied in the same way. The mass-proportional part (a of a M + b K) is not a
    material property and does not change. Modal damping has no members: with the place null all its loss
    factors are multiplied.
    """

    kind: ClassVar[str] = "loss_factor_error"
    summary: ClassVar[str] = "loss factor of members higher or lower than modelled"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    structural: ClassVar[bool] = True
    similar_kinds: ClassVar[tuple[str, ...]] = ("local_damping",)
    same_in_all_runs: ClassVar[bool] = True
    of_stated_damping: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Members)
    factor: float = parameter(
        2.0, unit="1", lower=0.0, upper=100.0, absent=1.0, doc="true loss factor over the model's"
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        if isinstance(self.at, Members):
            for number in self.at.numbers:
                system = system.alter(number, Alteration(loss=self.factor))
            return system
        return system.scaled(loss=self.factor)

    def check(self, structure: Structure, setup: RigSetup | None = None) -> None:
        """Raise unless its members are there and have a loss of their own; see `Effect.check`."""
        super().check(structure, setup)
        if isinstance(self.at, Members) and isinstance(structure.damping, ModalDamping):
            lossy_members = [m.number for m in structure.all_members if m.loss_factor]
            if not set(self.at.numbers) & set(lossy_members):
                raise self._misplaced(
                    f"null, as modal damping belongs to no member; or members {lossy_members}"
                )

    def added_to(self, structure: Structure) -> Structure:
        """Return the model with the loss factors corrected, where a model has a number for them."""
        law = structure.damping
        if isinstance(self.at, Members):
            if not isinstance(law, StructuralDamping):
                return super().added_to(structure)
            wrong, common = set(self.at.numbers), law.stiffness_coefficient
        else:
            wrong, common = {m.number for m in structure.all_members if m.loss_factor is not None}, 0.0
            if isinstance(law, ModalDamping):
                law = ModalDamping(tuple(self.factor * eta for eta in law.loss_factors))
            else:
                law = replace(law, stiffness_coefficient=self.factor * law.stiffness_coefficient)
        members = (
            replace(m, loss_factor=self.factor * (common if m.loss_factor is None else m.loss_factor))
            if m.number in wrong
            else m
            for m in structure.all_members
        )
        return replace(structure.of_members(members), damping=law)

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return the whole structure and every member with damping."""
        table = system.members
        if table is None:
            return ()
        losses = table.losses
        lossy = (losses.stiffness + losses.viscous_stiffness) > 0
        places_of_members = [
            Members((number,)) for number, is_lossy in zip(table.numbers, lossy, strict=True) if is_lossy
        ]
        return (None, *places_of_members) if places_of_members or system.modal else ()

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Peaks are too high or too low, at the frequencies of the model."""
        return 0.2 + 0.6 * evidence.at_peaks
