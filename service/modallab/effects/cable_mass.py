"""Mass and damping of accelerometer cables."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import NoneType
from typing import ClassVar, Self

import numpy as np

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.fe.attachment import Attachment
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("cable_mass")
@dataclass(frozen=True)
class CableMass(Effect):
    """The length of cable that moves with each accelerometer of a run: a mass m and a damper c = m drag.

    A wave that runs down a cable and is lost in it leaves a resistance at the accelerometer: sqrt(T mu)
    of a string of tension T and mass mu a metre, and of a stiff cable mu c_B / 2 in resistance and in
    mass reactance alike, with c_B its bending wave's speed (Cremer and Heckl, Structure-Borne Sound,
    1973, chapter IV). At 10 g/m either is some 0.01 to 0.1 N s/m. What moves and what it loses both
    grow with the cable, so the damper is told by its ratio to the mass. The mass alone is what a heavier
    accelerometer would be; the drag is what gives the cable away. At a DoF: one cable that stays there.
    """

    kind: ClassVar[str] = "cable_mass"
    summary: ClassVar[str] = "an accelerometer's cable loads the structure and damps it"
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

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        nodes = (
            [self.at.node]
            if isinstance(self.at, Dof)
            else sorted({dof.node for dof in acquisition_run.outputs})
        )
        for node in nodes:
            translations = tuple(dof for dof in system.dofs if dof.node == node and dof.translational)
            mass = self.mass * np.eye(len(translations))
            system = system.attach(Attachment(system.selection(translations), mass, viscous=self.drag * mass))
        return system

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
