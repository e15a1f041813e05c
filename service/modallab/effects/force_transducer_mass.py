"""Mass loading by the force transducer."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import NoneType
from typing import ClassVar, Self

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.correlation.evidence import Evidence
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("force_transducer_mass")
@dataclass(frozen=True)
class ForceTransducerMass(Effect):
    """Mass of the force transducer at the drive point in every run, part of the measured structure.

    M' = M + m e e^T, or F' = F + m a for the measured force F' and the force F on the structure; 1992
    thesis, section 5.4.1.
    """

    kind: ClassVar[str] = "force_transducer_mass"
    summary: ClassVar[str] = "mass of the force transducer that was not cancelled"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    at_drive: ClassVar[bool] = True
    mass: float = parameter(0.01, unit="kg", lower=0.0, upper=0.5, doc="mass below the sensing element")

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        for drive in acquisition_run.drives:
            if self.acts_on(drive):
                system = system.add_mass(drive.node, self.mass)
        return system

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        gauge = setup.force_transducer
        return [cls(mass=gauge.mass_below)] if gauge.mass_below > 0 and not gauge.mass_cancelled else []

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """All frequencies fall alike in every FRF."""
        return 0.3 + 0.4 * evidence.falling
