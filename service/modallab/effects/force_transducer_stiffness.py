"""Flexibility of the force transducer."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar, Self

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.rig.drive import Drive
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.settings import STINGER
from modallab.rig.setup import RigSetup


@EFFECTS.register("force_transducer_stiffness")
@dataclass(frozen=True)
class ForceTransducerStiffness(Effect):
    """A spring between the drive point and what is behind the gauge: x_2 = x + F/k.

    In series with the stinger: the armature resonates on both. The gauge shows the force through it, so
    that the FRF stays as it is. The stiffest is rigid. McConnell, Vibration Testing (1995), on force
    transducers.
    """

    kind: ClassVar[str] = "force_transducer_stiffness"
    summary: ClassVar[str] = "the force gauge gives way along its axis"
    stage: ClassVar[Stage] = Stage.DRIVE
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    at_drive: ClassVar[bool] = True
    suspected: ClassVar[bool] = False
    stiffness: float = parameter(
        1e8,
        unit="N/m",
        lower=STINGER.min_stiffness,
        upper=STINGER.max_stiffness,
        absent=STINGER.max_stiffness,
        scan_values=(1e6, 1e7, 1e8),
        doc="along the gauge's axis",
    )

    def on_drive(self, drive: Drive) -> Drive:
        if not self.acts_on(drive.dof) or self.stiffness == STINGER.max_stiffness:
            return drive
        return replace(drive, gauge_compliance=drive.gauge_compliance + 1 / self.stiffness)

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        stiffness = setup.force_transducer.stiffness
        return [cls(stiffness=stiffness)] if stiffness else []
