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
    """Axial flexibility of the force transducer between drive point and stinger, x_2 = x + F/k.

    It acts in series with the stinger: the armature resonates on both. The transducer measures the force
    that it transmits, so that the FRF does not change. The upper bound of the stiffness stands for a rigid
    transducer. McConnell, Vibration Testing (1995), on force transducers.
    """

    kind: ClassVar[str] = "force_transducer_stiffness"
    summary: ClassVar[str] = "axial flexibility of the force transducer"
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
        doc="along the axis of the force transducer",
    )

    def on_drive(self, drive: Drive) -> Drive:
        if not self.acts_on(drive.dof) or self.stiffness == STINGER.max_stiffness:
            return drive
        return replace(drive, gauge_compliance=drive.gauge_compliance + 1 / self.stiffness)

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        stiffness = setup.force_transducer.stiffness
        return [cls(stiffness=stiffness)] if stiffness else []
