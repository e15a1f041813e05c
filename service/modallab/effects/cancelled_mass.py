"""Inertia of a cancelled mass below the force gauge."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar, Self

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.rig.drive import Drive
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import RigSetup


@EFFECTS.register("cancelled_mass")
@dataclass(frozen=True)
class CancelledMass(Effect):
    """P = F + m a, with F the force behind the cancellation: the FRF is right, the source feels the mass.

    Mass cancellation subtracts m a from what the gauge shows; it leaves the FRF of the structure
    without the mass as long as the drive point moves along the gauge's axis (1992 thesis, section 5.4.5).
    """

    kind: ClassVar[str] = "cancelled_mass"
    summary: ClassVar[str] = "mass below the gauge that was cancelled still takes force from the source"
    stage: ClassVar[Stage] = Stage.DRIVE
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    at_drive: ClassVar[bool] = True
    suspected: ClassVar[bool] = False
    mass: float = parameter(0.01, unit="kg", lower=0.0, upper=0.5, doc="below the gauge, cancelled")

    def on_drive(self, drive: Drive) -> Drive:
        if not self.acts_on(drive.dof):
            return drive
        return replace(drive, cancelled_mass=drive.cancelled_mass + self.mass)

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        gauge = setup.force_transducer
        return [cls(mass=gauge.mass_below)] if gauge.mass_below > 0 and gauge.mass_cancelled else []
