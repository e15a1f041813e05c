"""Dry friction at one DoF."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import FRICTION_SCAN
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.likely_motion import distortion_suspicion, likely_motion
from modallab.rig.local_force import LocalForce
from modallab.rig.setup import RigSetup


@EFFECTS.register("friction")
@dataclass(frozen=True)
class Friction(Effect):
    """Coulomb friction from one DoF to the ground with a smoothed step, f = f_c tanh(v / v_s).

    For a Gaussian velocity of rms s, well above v_s, the equivalent damper is f_c sqrt(2/pi)/s: damping falls
    as the level rises. Booton (1954), IRE Trans. Circuit Theory 1, 9-18.
    """

    kind: ClassVar[str] = "friction"
    summary: ClassVar[str] = "dry friction: damping falls as the level rises"
    stage: ClassVar[Stage] = Stage.MOTION
    level_dependent: ClassVar[tuple[str, ...]] = ("force", "sticking")
    intermittent: ClassVar[bool] = True
    linearised_kinds: ClassVar[tuple[str, ...]] = ("local_damping", "ground_spring")
    structural: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (Dof,)
    force: float = parameter(0.05, unit="N", lower=0.0, upper=1e6, doc="Coulomb force")
    sticking: float = parameter(
        1e-3, unit="m/s", lower=1e-9, upper=1e3, absent=None, doc="velocity below which it acts as a damper"
    )

    def on_motion(self) -> LocalForce | None:
        assert isinstance(self.at, Dof)
        f, v = self.force, self.sticking
        if f == 0:
            return None
        return LocalForce(
            self.at,
            lambda x: f * np.tanh(x / v),
            lambda x: f / v * (1 - np.tanh(x / v) ** 2),
            of_velocity=True,
        )

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return every translation of the structure."""
        return tuple(dof for dof in system.dofs if dof.translational)

    def scan_values(self, system: DynamicSystem, setup: RigSetup) -> Mapping[str, Sequence[float]]:
        """Return forces with equivalent damping of 1e-3 to 1 of the DoF's mechanical resistance."""
        assert isinstance(self.at, Dof)
        motion = likely_motion(system, setup, self.at)
        viscous_force = motion.viscous * motion.velocity * np.sqrt(np.pi / 2)
        top = self.specs()["force"].upper
        sticking = float(np.clip(FRICTION_SCAN.sticking_ratio * motion.velocity, 1e-9, 1e3))
        forces = [min(share * viscous_force, top) for share in (1e-3, 1e-2, 1e-1, 1.0)]
        return {"force": forces, "sticking": [sticking]}

    def smoothed(self, system: DynamicSystem, setup: RigSetup) -> Effect:
        """Return friction that sticks at no velocity far below that of the motion.

        Coulomb friction proper takes five times as long to step through, and scatters alike.
        """
        assert isinstance(self.at, Dof)
        least = FRICTION_SCAN.least_sticking_ratio * likely_motion(system, setup, self.at).velocity
        return replace(self, sticking=least) if 0 < self.sticking < least else self

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Part of the response has nothing in common with the force."""
        return 0.6 * distortion_suspicion(evidence)
