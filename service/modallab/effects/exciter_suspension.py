"""Suspension of the exciter's armature."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar, Self

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.rig.drive import Drive
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import RigSetup


@EFFECTS.register("exciter_suspension")
@dataclass(frozen=True)
class ExciterSuspension(Effect):
    """Suspension of the armature in its frame, F_s = (k + i omega c) x_a, behind the force transducer.

    It is part of the impedance that the source drives, P = F + (k + i omega c - omega^2 m) x for a rigid
    stinger. This is equation 5.2 of the 1992 thesis with a suspension, which the thesis neglects. The FRF
    does not change.
    """

    kind: ClassVar[str] = "exciter_suspension"
    summary: ClassVar[str] = "suspension of the armature reduces the force at low frequencies"
    stage: ClassVar[Stage] = Stage.DRIVE
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    at_drive: ClassVar[bool] = True
    suspected: ClassVar[bool] = False
    stiffness: float = parameter(5e3, unit="N/m", lower=0.0, upper=1e8, doc="armature to its frame")
    damping: float = parameter(1.0, unit="N s/m", lower=0.0, upper=1e5, doc="armature to its frame")

    def on_drive(self, drive: Drive) -> Drive:
        if not self.acts_on(drive.dof):
            return drive
        stiffness, viscous = drive.stiffness + self.stiffness, drive.viscous + self.damping
        return replace(drive, stiffness=stiffness, viscous=viscous)

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        stiffness, damping = setup.exciter.suspension_stiffness, setup.exciter.suspension_damping
        return [cls(stiffness=stiffness, damping=damping)] if stiffness > 0 or damping > 0 else []
