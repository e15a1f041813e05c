"""Unmodelled viscous damper to the ground."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("local_damping")
@dataclass(frozen=True)
class LocalDamping(Effect):
    """Viscous damper c between a translation and the ground, C' = C + c e e^T.

    To first order the loss factor of a mode grows by c phi^2 / omega, from the energy c omega^2 phi^2 pi
    dissipated in a cycle; a very large damper fixes the point, and the dissipation decreases again. Energy
    balance: Ungar and Kerwin, J. Acoust. Soc. Am. 34 (1962) 954-957.
    """

    kind: ClassVar[str] = "local_damping"
    summary: ClassVar[str] = "damper at one point that the model lacks"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    structural: ClassVar[bool] = True
    similar_kinds: ClassVar[tuple[str, ...]] = ("loss_factor_error",)
    same_in_all_runs: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (Dof,)
    damping: float = parameter(
        2.0, unit="N s/m", lower=0.0, upper=1e6, doc="damper from the DoF to the ground"
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        assert isinstance(self.at, Dof)
        return system.add_damper(self.at, self.damping)

    def check(self, structure: Structure, setup: RigSetup | None = None) -> None:
        """Raise unless it sits at a translation of the structure; see `Effect.check`."""
        super().check(structure, setup)
        if isinstance(self.at, Dof) and not self.at.translational:
            raise self._misplaced("a translation")

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return every translation of the structure."""
        return tuple(dof for dof in system.dofs if dof.translational)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Peaks are too high or too low, at the frequencies of the model."""
        return 0.2 + 0.5 * evidence.at_peaks
