"""Unmodelled rotational spring to the ground."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.fe.structure import GroundSpringElement as ModelledSpring
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("rotational_ground_spring")
@dataclass(frozen=True)
class RotationalGroundSpring(Effect):
    """Rotational spring without loss between a node and the ground, K' = K + k_t e e^T.

    Examples: a flexible clamp, a pin with friction. From 0 to infinity the support changes from pinned to
    clamped. Frequencies against k_t L / (E I): Blevins, Formulas for Natural Frequency and Mode Shape
    (1979), section 8.1.
    """

    kind: ClassVar[str] = "rotational_ground_spring"
    summary: ClassVar[str] = "rotational spring to the ground that the model lacks"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    structural: ClassVar[bool] = True
    same_in_all_runs: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (Dof,)
    stiffness: float = parameter(
        100.0, unit="N m/rad", lower=0.0, upper=1e12, doc="spring from the rotation to the ground"
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        assert isinstance(self.at, Dof)
        return system.add_spring(self.at, self.stiffness)

    def check(self, structure: Structure, setup: RigSetup | None = None) -> None:
        """Raise unless it sits at a rotation of the structure; see `Effect.check`."""
        super().check(structure, setup)
        if isinstance(self.at, Dof) and self.at.translational:
            raise self._misplaced("a rotation; at a translation it is a ground_spring")

    def added_to(self, structure: Structure) -> Structure:
        """Return the model with the spring in it."""
        assert isinstance(self.at, Dof)
        return replace(structure, springs=(*structure.springs, ModelledSpring(self.at, self.stiffness)))

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return every rotation of the structure."""
        return tuple(dof for dof in system.dofs if not dof.translational)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Frequencies rise, the low ones most."""
        return 0.3 + 0.3 * evidence.rising
