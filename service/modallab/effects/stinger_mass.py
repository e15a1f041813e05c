"""Mass of the stinger."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar, Self

import numpy as np

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.fe.attachment import Attachment
from modallab.fe.system import DynamicSystem
from modallab.rig.drive import Drive
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.settings import STINGER
from modallab.rig.setup import AcquisitionRun, RigSetup
from modallab.rig.stinger import lateral_ends


@EFFECTS.register("stinger_mass")
@dataclass(frozen=True)
class StingerMass(Effect):
    """Mass of the stinger, a rod of mass m and axial stiffness k with axial waves: t = omega sqrt(m/k).

    Between its ends [F, F] = k t [[cot t, -1/sin t], [-1/sin t, cot t]] [x, x]. Far below the first axial
    resonance, t = pi, half of the mass moves with the force transducer, behind its sensing element, and
    half with the armature. Lateral motion and slope of the drive point move the mass m/420 [[156, 22 L],
    [22 L, 4 L^2]], which is not part of the measured force. From the wave equation of a rod, and the cubic
    deflection of a rod clamped in the armature; k is that of `stinger_axial`. Bishop and Johnson, The
    Mechanics of Vibration (1960), on rods.
    """

    kind: ClassVar[str] = "stinger_mass"
    summary: ClassVar[str] = "inertia of the stinger reduces the force"
    stage: ClassVar[Stage] = Stage.DRIVE
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    at_drive: ClassVar[bool] = True
    suspected: ClassVar[bool] = False
    mass: float = parameter(1e-3, unit="kg", lower=0.0, upper=STINGER.max_mass, doc="of the whole stinger")
    length: float = parameter(
        0.05,
        unit="m",
        lower=STINGER.min_length,
        upper=STINGER.max_length,
        absent=None,
        doc="from armature to force transducer",
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        reach = self.length
        end = self.mass / 420 * np.array([[156.0, 22 * reach], [22 * reach, 4 * reach**2]])
        for drive in acquisition_run.drives:
            if self.acts_on(drive):
                for columns, free in lateral_ends(system, drive):
                    system = system.attach(Attachment(columns, mass=end[np.ix_(free, free)]))
        return system

    def on_drive(self, drive: Drive) -> Drive:
        if not self.acts_on(drive.dof):
            return drive
        return replace(drive, stinger_mass=drive.stinger_mass + self.mass)

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        return (
            []
            if setup.stinger is None or setup.stinger.mass == 0
            else [cls(mass=setup.stinger.mass, length=setup.stinger.length)]
        )
