"""Support that is elastic in a direction in which the model holds it rigidly."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import SUPPORT_SCAN
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("elastic_support")
@dataclass(frozen=True)
class ElasticSupport(Effect):
    """Spring without loss between a held translation and the ground, x = -flexibility reaction.

    The model holds the DoF: flexibility 0. Point masses of the node move with it. To first order a mode
    falls by d(omega^2) = -flexibility r^2, with r the reaction of the mass-normalised mode at the rigid
    support. Blevins, Formulas for Natural Frequency and Mode Shape (1979), section 8.1, on beams with
    springs as supports.
    """

    kind: ClassVar[str] = "elastic_support"
    summary: ClassVar[str] = "support that yields along a direction in which the model holds it"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    structural: ClassVar[bool] = True
    same_in_all_runs: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (Dof,)
    flexibility: float = parameter(
        1e-6, unit="m/N", lower=0.0, upper=1e3, doc="displacement of the support per force; 0 is rigid"
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        assert isinstance(self.at, Dof)
        return system.soften_support(self.at, self.flexibility)

    def check(self, structure: Structure, setup: RigSetup | None = None) -> None:
        """Raise unless it sits at a translation that a support holds; see `Effect.check`."""
        held = [dof for dof in structure.held_dofs if dof.translational]
        if not isinstance(self.at, Dof) or self.at.point not in held:
            raise self._misplaced([str(dof) for dof in held])

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return every translation that a support holds and that members carry."""
        return tuple(dof for dof in system.loaded_supports if dof.translational)

    def scan_values(self, system: DynamicSystem, setup: RigSetup) -> Mapping[str, Sequence[float]]:
        """Return flexibilities around that of the members there."""
        assert isinstance(self.at, Dof)
        member_stiffness = system.stiffness_at_support(self.at)
        upper = self.specs()["flexibility"].upper
        ratios = SUPPORT_SCAN.along
        return {"flexibility": [float(r / member_stiffness) for r in ratios if r < upper * member_stiffness]}

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Frequencies fall, the low ones most."""
        return 0.3 + 0.4 * evidence.falling
