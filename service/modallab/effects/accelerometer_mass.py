"""Mass loading by accelerometers."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import NoneType
from typing import ClassVar, Self

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.fe.point_translations import add_point_masses
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("accelerometer_mass")
@dataclass(frozen=True)
class AccelerometerMass(Effect):
    """Mass of the accelerometers of a run at their places; a roving one has another place in each run.

    M' = M + m e e^T at every channel of the run. Example: the frequency f of a rigid body becomes f sqrt(M
    / (M + m)). With a DoF as place: one accelerometer that stays there in every run. 1992 thesis, section
    5.4.1.
    """

    kind: ClassVar[str] = "accelerometer_mass"
    summary: ClassVar[str] = "mass of the accelerometers lowers natural frequencies"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    mass: float = parameter(0.02, unit="kg", lower=0.0, upper=0.5, doc="accelerometer with its stud")

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        points = [(self.at.node, 0.0)] if isinstance(self.at, Dof) else acquisition_run.accelerometer_points
        return add_point_masses(system, points, self.mass)

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        return [cls(mass=setup.accelerometers.mass)] if setup.accelerometers.mass > 0 else []

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        return (None,)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Frequencies fall, and the FRFs of different positions disagree on them."""
        return 0.3 + 0.4 * evidence.falling
