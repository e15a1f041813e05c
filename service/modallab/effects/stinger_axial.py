"""Axial flexibility of the stinger."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar, Self

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.correlation.evidence import Evidence
from modallab.rig.drive import Drive
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.settings import STINGER
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
    summary: ClassVar[str] = "axial flexibility of the stinger: armature and structure resonate on it"
    stage: ClassVar[Stage] = Stage.DRIVE
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    at_drive: ClassVar[bool] = True
    stiffness: float = parameter(
        2e6,
        unit="N/m",
        lower=STINGER.min_stiffness,
        upper=STINGER.max_stiffness,
        absent=STINGER.max_stiffness,
        scan_values=(3e4, 1e5, 3e5, 1e6, 3e6, 1e7, 1e8),
        doc="along the stinger's axis",
    )

    def on_drive(self, drive: Drive) -> Drive:
        if not self.acts_on(drive.dof) or self.stiffness == STINGER.max_stiffness:
            return drive
        return replace(drive, compliance=drive.compliance + 1 / self.stiffness)

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        declared = None if setup.stinger is None else setup.stinger.axial_stiffness
        return [] if declared is None else [cls(stiffness=declared)]

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Return the evidence of a wrong force spectrum."""
        return evidence.wrong_force
