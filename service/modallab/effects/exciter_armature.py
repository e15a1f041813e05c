"""Inertia of the exciter's armature."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar, Self

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import ARMATURE_SCAN
from modallab.rig.drive import Drive
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import RigSetup

_TRIAL_MASSES = tuple(
    ARMATURE_SCAN.max_mass * 10.0 ** (-i / ARMATURE_SCAN.values_per_decade)
    for i in range(ARMATURE_SCAN.n_values)
)


@EFFECTS.register("exciter_armature")
@dataclass(frozen=True)
class ExciterArmature(Effect):
    """Inertia of the armature behind the force transducer, P = F + m a: 1992 thesis, equations 5.2, 5.3.

    The FRF a/F does not change; the force spectrum has a dip at every resonance.
    """

    kind: ClassVar[str] = "exciter_armature"
    summary: ClassVar[str] = "inertia of the armature reduces the force at resonances"
    stage: ClassVar[Stage] = Stage.DRIVE
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    at_drive: ClassVar[bool] = True
    mass: float = parameter(
        0.02,
        unit="kg",
        lower=0.0,
        upper=5.0,
        doc="moving mass behind the force transducer",
        scan_values=_TRIAL_MASSES,
    )

    def on_drive(self, drive: Drive) -> Drive:
        return replace(drive, mass=drive.mass + self.mass) if self.acts_on(drive.dof) else drive

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        mass = setup.exciter.armature_mass
        return [cls(mass=mass)] if mass > 0 else []

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Return the evidence of a wrong force spectrum."""
        return evidence.wrong_force
