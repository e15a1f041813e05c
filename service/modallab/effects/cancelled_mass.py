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
    """Inertia of a cancelled mass in the drive: P = F + m a, with F the force after cancellation.

    Mass cancellation subtracts m a from the reading of the force transducer. The FRF is then that of the
    structure without the mass, if the drive point moves along the axis of the transducer; the source still
    moves the mass (1992 thesis, section 5.4.5).
    """

    kind: ClassVar[str] = "cancelled_mass"
    summary: ClassVar[str] = "cancelled mass of the force transducer still loads the source"
    stage: ClassVar[Stage] = Stage.DRIVE
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    at_drive: ClassVar[bool] = True
    suspected: ClassVar[bool] = False
    mass: float = parameter(
        0.01, unit="kg", lower=0.0, upper=0.5, doc="cancelled mass, below the sensing element"
    )

    def on_drive(self, drive: Drive) -> Drive:
        if not self.acts_on(drive.dof):
            return drive
        return replace(drive, cancelled_mass=drive.cancelled_mass + self.mass)

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        gauge = setup.force_transducer
        return [cls(mass=gauge.mass_below)] if gauge.mass_below > 0 and gauge.mass_cancelled else []
