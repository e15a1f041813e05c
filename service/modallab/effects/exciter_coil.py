"""Back-EMF of the exciter's coil."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar, Self

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.rig.drive import Drive
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.hardware import Coil
from modallab.rig.setup import RigSetup


@EFFECTS.register("exciter_coil")
@dataclass(frozen=True)
class ExciterCoil(Effect):
    """Back-EMF of the voice coil: P = BL E/(R + i omega L) - i omega x_a BL^2/(R + i omega L).

    The declared source force is that of the voltage E at 0 Hz with a fixed armature, BL E/R. The actual
    force lags by R/(R + i omega L), and is reduced in proportion to the velocity by the induced voltage.
    The FRF does not change. From E = (R + i omega L) I + BL v and P = BL I, the electrodynamic shaker of
    textbooks (McConnell, Vibration Testing, 1995). An amplifier that controls the current removes the
    effect.
    """

    kind: ClassVar[str] = "exciter_coil"
    summary: ClassVar[str] = "back-EMF of a voltage-driven coil damps the armature"
    stage: ClassVar[Stage] = Stage.DRIVE
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    at_drive: ClassVar[bool] = True
    suspected: ClassVar[bool] = False
    force_factor: float = parameter(8.0, unit="N/A", lower=0.0, upper=100.0, doc="force per current, BL")
    resistance: float = parameter(
        2.0, unit="Ohm", lower=0.1, upper=1e4, absent=None, doc="of coil and amplifier"
    )
    inductance: float = parameter(2e-4, unit="H", lower=0.0, upper=0.1, absent=0.0, doc="of the coil")

    def on_drive(self, drive: Drive) -> Drive:
        if not self.acts_on(drive.dof):
            return drive
        return replace(drive, coils=(*drive.coils, Coil(self.force_factor, self.resistance, self.inductance)))

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        coil = setup.exciter.coil
        if coil is None or setup.exciter.amplifier == "current":
            return []
        return [cls(force_factor=coil.force_factor, resistance=coil.resistance, inductance=coil.inductance)]
