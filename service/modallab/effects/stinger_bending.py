"""Bending stiffness of the stinger."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import NoneType
from typing import ClassVar, Self

import numpy as np

from modallab.core.dof import Dof
from modallab.core.parameters import parameter, share_parameter
from modallab.correlation.evidence import Evidence
from modallab.fe.attachment import Attachment
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.settings import STINGER
from modallab.rig.setup import AcquisitionRun, RigSetup
from modallab.rig.stinger import lateral_ends


@EFFECTS.register("stinger_bending")
@dataclass(frozen=True)
class StingerBending(Effect):
    """Restraint of rotation and lateral motion of the drive point by a slender rod, clamped in the armature.

    In each plane through the axis [F, M] = EI [[12/L^3, 6/L^2], [6/L^2, 4/L]] [lateral motion, slope],
    without the mass of the rod: far below its first bending mode. The rod extends from the structure
    against the direction of the drive. It changes the structure and not the measured force, so that mass
    cancellation does not remove it: 1992 thesis, section 5.4.5 and appendix D. A stinger with flexures may
    restrain both without coupling them; a diagnosis tries that too.
    """

    kind: ClassVar[str] = "stinger_bending"
    summary: ClassVar[str] = "stinger restrains rotation and lateral motion of the drive point"
    title: ClassVar[str] = "bending stiffness of the stinger"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    at_drive: ClassVar[bool] = True
    stiffness: float = parameter(
        10.0, unit="N m/rad", lower=0.0, upper=STINGER.max_bending_stiffness, doc="moment per rotation, 4EI/L"
    )
    length: float = parameter(
        0.05,
        unit="m",
        lower=STINGER.min_length,
        upper=STINGER.max_length,
        absent=None,
        scan_values=(0.05, 0.5),
        doc="of the rod: its lateral stiffness is three times the one in rotation, over length^2",
    )
    coupling: float = share_parameter(
        doc="of rotation and lateral motion, over a clamped rod's; 0: two springs apart, as of flexures",
        scan_values=(0.0, 1.0),
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        reach = self.length
        coupled = 1.5 * self.coupling / reach
        end = self.stiffness * np.array([[3 / reach**2, coupled], [coupled, 1.0]])
        for drive in acquisition_run.drives:
            if self.acts_on(drive):
                for columns, free in lateral_ends(system, drive):
                    system = system.attach(Attachment(columns, stiffness=end[np.ix_(free, free)]))
        return system

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        stinger = setup.stinger
        if stinger is None or stinger.bending_stiffness == 0:
            return []
        return [cls(stiffness=stinger.bending_stiffness, length=stinger.length)]

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Frequencies rise in every FRF."""
        return 0.3 + 0.4 * evidence.rising
