"""Mass and damping of accelerometer cables."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import NoneType
from typing import ClassVar, Self

import numpy as np

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import CABLE_SCAN
from modallab.fe.attachment import Attachment
from modallab.fe.point_translations import point_translations
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("cable_mass")
@dataclass(frozen=True)
class CableMass(Effect):
    """Cable that moves with each accelerometer of a run: a mass m and a damper c = m drag.

    A wave that travels along a cable and is absorbed acts as a resistance at the accelerometer: sqrt(T mu)
    for a string of tension T and mass per length mu; for a stiff cable mu c_B / 2, with c_B the speed of
    bending waves, and a mass reactance of the same size (Cremer and Heckl, Structure-Borne Sound, 1973,
    chapter IV). At 10 g/m either is about 0.01 to 0.1 N s/m. Moving mass and damping both grow with the
    cable; the parameter is therefore their ratio. The mass alone is equivalent to a heavier accelerometer;
    the damping distinguishes the cable. A cable hangs from its clamp over the whole way to the accelerometer:
    m' = m (1 + g l), with l the sum of the distances along the axes from the structure's corner of lowest
    coordinates, of bars in a plane. With a DoF as place: one cable that stays there.
    """

    kind: ClassVar[str] = "cable_mass"
    summary: ClassVar[str] = "accelerometer cables load and damp the structure"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    nested_kind: ClassVar[str | None] = "accelerometer_mass"
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Dof)
    mass: float = parameter(
        0.005, unit="kg", lower=0.0, upper=0.5, doc="cable that moves with each accelerometer"
    )
    drag: float = parameter(
        20.0,
        unit="1/s",
        lower=0.0,
        upper=1e5,
        absent=None,
        doc="damping over mass",
        scan_values=(20.0, 500.0),
    )
    growth: float = parameter(
        0.0,
        unit="1/m",
        lower=0.0,
        upper=1e3,
        absent=None,
        doc="relative growth of the mass with the distance from the structure's lower left corner",
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        points = [(self.at.node, 0.0)] if isinstance(self.at, Dof) else acquisition_run.accelerometer_points
        for point in points:
            columns = point_translations(system, point)
            mass = self._mass_at(point[0], system) * np.eye(columns.shape[1])
            system = system.attach(Attachment(columns, mass, viscous=self.drag * mass))
        return system

    def _mass_at(self, node: int, system: DynamicSystem) -> float:
        """Return the mass, kg, that moves at a node."""
        table = system.members
        if self.growth == 0 or table is None or not table.bars.all():
            return self.mass
        points = table.points.reshape(-1, 2)
        at_node = points[np.ravel(table.ends) == node]
        return self.mass * (1 + self.growth * float((at_node[0] - points.min(axis=0)).sum()))

    def scan_values(self, system: DynamicSystem, setup: RigSetup) -> Mapping[str, Sequence[float]]:
        """Return no growth, and one by several times the mass over the structure."""
        table = system.members
        if table is None or not table.bars.all():
            return {"growth": [0.0]}
        size = float(np.ptp(table.points.reshape(-1, 2), axis=0).sum())
        return {"growth": [0.0, CABLE_SCAN.growth / size]}

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        mass = setup.accelerometers.cable_mass
        return [cls(mass=mass)] if mass > 0 else []

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        return (None,)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Frequencies fall, and peaks are lower than predicted."""
        return 0.2 + 0.2 * evidence.falling + 0.3 * evidence.at_peaks
