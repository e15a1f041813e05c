"""Axial flexibility of the stinger."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar, Self

import numpy as np

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import STINGER_SCAN
from modallab.fe.system import DynamicSystem
from modallab.rig.drive import Drive
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.settings import DRIVE, STINGER
from modallab.rig.setup import RigSetup


@EFFECTS.register("stinger_axial")
@dataclass(frozen=True)
class StingerAxial(Effect):
    """Axial flexibility of the stinger between armature and force transducer, x_a = x + F/k.

    F = P/(1 + Z_a (1/k + alpha)). With the drive point at rest the armature resonates at sqrt(k/m_a)/(2 pi):
    1992 thesis, equation D.4; k = EA/L of a rod, equation D.5. Above this frequency the force decreases; the
    FRF does not change. The upper bound of the stiffness stands for a rigid stinger.
    """

    kind: ClassVar[str] = "stinger_axial"
    summary: ClassVar[str] = "armature and structure resonate on the stinger, along its axis"
    title: ClassVar[str] = "axial flexibility of the stinger"
    stage: ClassVar[Stage] = Stage.DRIVE
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    at_drive: ClassVar[bool] = True
    stiffness: float = parameter(
        2e6,
        unit="N/m",
        lower=STINGER.min_stiffness,
        upper=STINGER.max_stiffness,
        absent=STINGER.max_stiffness,
        doc="along the stinger's axis",
    )
    loss_factor: float = parameter(
        DRIVE.joint_loss_factor, unit="1", lower=1e-4, upper=1.0, absent=None, doc="of the stinger"
    )

    def on_drive(self, drive: Drive) -> Drive:
        if not self.acts_on(drive.dof) or self.stiffness == STINGER.max_stiffness:
            return drive
        return replace(
            drive, compliance=drive.compliance + 1 / self.stiffness, stinger_loss_factor=self.loss_factor
        )

    def scan_values(self, system: DynamicSystem, setup: RigSetup) -> Mapping[str, Sequence[float]]:
        """Return stiffnesses on which the armature resonates in the band or above it."""
        mass = setup.exciter.armature_mass
        if not mass:
            return {"stiffness": STINGER_SCAN.stiffnesses}
        natural = 2 * np.pi * setup.analyser.freq[-1] * STINGER_SCAN.frequencies
        stiffnesses = mass * natural**2
        bounds = self.specs()["stiffness"]
        return {"stiffness": [float(k) for k in stiffnesses if bounds.lower <= k < bounds.upper]}

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        declared = None if setup.stinger is None else setup.stinger.axial_stiffness
        return [] if declared is None else [cls(stiffness=declared)]

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Return the evidence of a wrong force spectrum."""
        return evidence.wrong_force
