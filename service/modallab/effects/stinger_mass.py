"""A stinger has a mass of its own."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar, Self

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.rig.drive import Drive
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.setup import RigSetup
from modallab.rig.stinger import HEAVIEST


@EFFECTS.register("stinger_mass")
@dataclass(frozen=True)
class StingerMass(Effect):
    """A rod of mass m and stiffness k carries waves along its axis: t = omega sqrt(m/k).

    Between its ends [F, F] = k t [[cot t, -1/sin t], [-1/sin t, cot t]] [x, x]; far below its own first axial
    resonance, t = pi, half the mass moves with the force gauge, behind its sensing element, and half with the
    armature. The FRF stays as it is. From the wave equation of a rod; k is that of `stinger_axial`.
    """

    kind: ClassVar[str] = "stinger_mass"
    summary: ClassVar[str] = "the mass of the stinger takes force to move"
    stage: ClassVar[int] = 3
    sits: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    at_drive: ClassVar[bool] = True
    suspected: ClassVar[bool] = False
    mass: float = parameter(1e-3, unit="kg", lower=0.0, upper=HEAVIEST, doc="of the whole stinger")

    def on_drive(self, drive: Drive) -> Drive:
        if not self.acts_on(drive.dof):
            return drive
        return replace(drive, stinger_mass=drive.stinger_mass + self.mass)

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        return [] if setup.stinger is None or setup.stinger.mass == 0 else [cls(mass=setup.stinger.mass)]
