"""Rattle: elastic stops beyond a gap."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.likely_motion import distortion_suspicion
from modallab.rig.local_force import LocalForce
from modallab.rig.setup import RigSetup


@EFFECTS.register("rattle")
@dataclass(frozen=True)
class Rattle(Effect):
    """Stops on both sides of a gap g, f = k (x - g) beyond the gap and 0 within it.

    Examples: a loose part, a bolt in its hole. For a Gaussian motion of rms s the equivalent spring is k
    erfc(g / (s sqrt 2)): 0 while the motion stays within the gap, k far beyond it. Booton (1954), IRE
    Trans. Circuit Theory 1, 9-18.
    """

    kind: ClassVar[str] = "rattle"
    summary: ClassVar[str] = "stops that the structure strikes above a certain level"
    stage: ClassVar[Stage] = Stage.MOTION
    level_dependent: ClassVar[tuple[str, ...]] = ("gap",)
    intermittent: ClassVar[bool] = True
    linearised_kinds: ClassVar[tuple[str, ...]] = ("ground_spring",)
    structural: ClassVar[bool] = True
    suspected: ClassVar[bool] = False
    allowed_places: ClassVar[tuple[type, ...]] = (Dof,)
    stiffness: float = parameter(1e4, unit="N/m", lower=0.0, upper=1e12, doc="of the stops")
    gap: float = parameter(
        1e-5, unit="m", lower=1e-12, upper=1.0, absent=None, doc="free distance on either side"
    )

    def on_motion(self) -> LocalForce | None:
        assert isinstance(self.at, Dof)
        k, g = self.stiffness, self.gap
        if k == 0:
            return None
        return LocalForce(
            self.at,
            lambda x: k * (x - np.clip(x, -g, g)),
            lambda x: np.where(np.abs(x) > g, k, 0.0),
        )

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return every translation of the structure."""
        return tuple(dof for dof in system.dofs if dof.translational)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Frequencies rise, and part of the response has nothing in common with the force."""
        return distortion_suspicion(evidence) * (0.5 + 0.3 * evidence.rising)
