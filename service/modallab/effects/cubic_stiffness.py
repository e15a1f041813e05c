"""Cubic spring to the ground."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.likely_motion import distortion_suspicion, likely_motion
from modallab.rig.local_force import LocalForce
from modallab.rig.setup import RigSetup


@EFFECTS.register("cubic_stiffness")
@dataclass(frozen=True)
class CubicStiffness(Effect):
    """Cubic spring from one DoF to the ground, f = k_3 x^3.

    For a Gaussian motion of rms s the equivalent spring is 3 k_3 s^2, and the remaining force is
    uncorrelated with the motion and has the power 6 k_3^2 s^6: frequencies rise with the level and
    coherence falls. Booton (1954), IRE Trans. Circuit Theory 1, 9-18.
    """

    kind: ClassVar[str] = "cubic_stiffness"
    summary: ClassVar[str] = "hardening spring: frequencies rise with the level"
    stage: ClassVar[Stage] = Stage.MOTION
    level_dependent: ClassVar[tuple[str, ...]] = ("stiffness",)
    intermittent: ClassVar[bool] = True
    linearised_kinds: ClassVar[tuple[str, ...]] = ("ground_spring",)
    structural: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (Dof,)
    stiffness: float = parameter(
        3e8, unit="N/m^3", lower=0.0, upper=1e24, doc="force over the cube of the motion"
    )

    def on_motion(self) -> LocalForce | None:
        assert isinstance(self.at, Dof)
        k = self.stiffness
        if k == 0:
            return None
        return LocalForce(self.at, lambda x: k * (x * x * x), lambda x: 3 * k * (x * x), degree=3)

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return every translation of the structure."""
        return tuple(dof for dof in system.dofs if dof.translational)

    def scan_values(self, system: DynamicSystem, setup: RigSetup) -> Mapping[str, Sequence[float]]:
        """Return coefficients with equivalent stiffnesses of 1e-4 to 1 of the DoF's dynamic stiffness."""
        assert isinstance(self.at, Dof)
        motion = likely_motion(system, setup, self.at)
        largest_stiffness = motion.stiffness / (3 * motion.displacement**2)
        top = self.specs()["stiffness"].upper
        return {"stiffness": [min(share * largest_stiffness, top) for share in (1e-4, 1e-3, 1e-2, 1e-1, 1.0)]}

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Frequencies rise, and part of the response has nothing in common with the force."""
        return distortion_suspicion(evidence) * (0.5 + 0.3 * evidence.rising)
