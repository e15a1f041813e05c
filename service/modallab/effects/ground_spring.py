"""Unmodelled spring to the ground."""

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


@EFFECTS.register("ground_spring")
@dataclass(frozen=True)
class GroundSpring(Effect):
    """Spring without loss between a translation and the ground, K' = K + k_g e e^T.

    Examples: a flexible support, a fixture, a lateral string. To first order the relative increase of the
    frequency of a mode is k_g phi^2 / (2 omega^2); a free body of mass M bounces at sqrt(k_g/M).
    Meirovitch, Principles and Techniques of Vibrations (1997), on Rayleigh's quotient.
    """

    kind: ClassVar[str] = "ground_spring"
    summary: ClassVar[str] = "spring to the ground that the model lacks"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    structural: ClassVar[bool] = True
    similar_kinds: ClassVar[tuple[str, ...]] = ("suspension",)
    same_in_all_runs: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (Dof,)
    stiffness: float = parameter(
        1e4, unit="N/m", lower=0.0, upper=1e12, doc="spring from the DoF to the ground"
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        assert isinstance(self.at, Dof)
        return system.add_spring(self.at, self.stiffness)

    def check(self, structure: Structure, setup: RigSetup | None = None) -> None:
        """Raise unless it sits at a translation of the structure; see `Effect.check`."""
        super().check(structure, setup)
        if isinstance(self.at, Dof) and not self.at.translational:
            raise self._misplaced("a translation; at a rotation it is a rotational_ground_spring")

    def added_to(self, structure: Structure) -> Structure:
        """Return the model with the spring in it."""
        assert isinstance(self.at, Dof)
        return replace(structure, springs=(*structure.springs, ModelledSpring(self.at, self.stiffness)))

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return every translation of the structure."""
        return tuple(dof for dof in system.dofs if dof.translational)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Frequencies rise, the low ones most."""
        return 0.3 + 0.4 * evidence.rising
