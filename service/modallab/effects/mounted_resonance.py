"""Mounted resonance of accelerometers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import NoneType
from typing import ClassVar, Self

import numpy as np

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Channels, Place
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import MOUNTING, MOUNTING_SCAN
from modallab.fe.attachment import Attachment
from modallab.fe.system import DynamicSystem
from modallab.rig.channel import Channel
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.mounting import reading
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("mounted_resonance")
@dataclass(frozen=True)
class MountedResonance(Effect):
    """Resonance of the accelerometer on its mounting, H' = H (1 + i loss r)/(1 - r^2 + i loss r).

    r = f/f_0. The accelerometer vibrates on the spring of its mounting, and reads its own motion: 12.5 % too
    much at f_0/3 and 4.2 % at f_0/5; rules of thumb state 10 % and 5 %. Serridge and Licht, Piezoelectric
    Accelerometers and Vibration Preamplifiers (1987), chapter 2. Its mass m loads the structure through the
    same spring, along its axis: with m (1 + i loss r)/(1 - r^2 + i loss r); across it as a rigid mass, or
    in the same way. Mountings above 20 kHz load it as rigid ones do.
    """

    kind: ClassVar[str] = "mounted_resonance"
    summary: ClassVar[str] = "resonance of an accelerometer on its mounting: reading too high"
    stage: ClassVar[Stage] = Stage.CHANNEL
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Channels)
    frequency: float = parameter(
        7e3,
        unit="Hz",
        lower=10.0,
        upper=1e9,
        absent=1e9,  # 1e-6 of the reading at 1 MHz, 1e-12 at 1 kHz
        doc="mounted resonance",
    )
    loss: float = parameter(
        0.05, unit="1", lower=1e-3, upper=1.0, absent=None, doc="twice the damping ratio of the mounting"
    )
    transverse: float = parameter(
        0.0,
        unit="1",
        lower=0.0,
        upper=1.0,
        absent=None,
        doc="share of the mass that resonates across the axis too; 0: the mounting is rigid there",
        alternative=1.0,
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        if not acquisition_run.accelerometer_mass or self.frequency > MOUNTING.rigid_frequency:
            return system
        displaced, mass = dict(acquisition_run.displaced_accelerometers), acquisition_run.accelerometer_mass
        for dof in acquisition_run.outputs:
            if self.acts_on(dof) and dof.node not in displaced:
                system = system.attach(self._on_spring(system, dof, mass))
                for other in system.translations(dof.node) if self.transverse else ():
                    if other.direction != dof.direction:
                        system = system.attach(self._on_spring(system, other, self.transverse * mass))
        return system

    def variants(self, system: DynamicSystem) -> tuple[Self, ...]:
        """Return the other choice of a resonance across the axis, where a node moves so."""
        moves = len({dof.direction for dof in system.dofs if dof.translational}) > 1
        return super().variants(system) if moves else ()

    def _on_spring(self, system: DynamicSystem, dof: Dof, mass: float) -> Attachment:
        """Return the mass on its spring less the mass that is attached already."""
        between = np.array([[1.0, -1.0], [-1.0, 1.0]])
        natural = 2 * np.pi * self.frequency
        return Attachment(
            system.selection((dof,)),
            mass=np.diag([-mass, mass]),
            stiffness=mass * natural**2 * between,
            viscous=mass * natural * self.loss * between,
            inner=1,
        )

    def on_channel(self, channel: Channel, system: DynamicSystem) -> Channel:
        if channel.force or not self.acts_on(channel.dof):
            return channel
        return channel.with_filter(lambda omega: reading(omega / (2 * np.pi * self.frequency), self.loss))

    def scan_values(self, system: DynamicSystem, setup: RigSetup) -> Mapping[str, Sequence[float]]:
        """Return frequencies in the band and above it."""
        top = setup.analyser.freq[-1]
        frequencies = top * np.append(MOUNTING_SCAN.frequencies, MOUNTING_SCAN.far)
        bounds = self.specs()["frequency"]
        return {"frequency": [float(f) for f in frequencies if bounds.lower <= f < bounds.upper]}

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        mounting = setup.accelerometers.effective_mounting
        return [cls(frequency=mounting.frequency, loss=mounting.loss)] if mounting else []

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        return (None, *(Channels((dof,)) for dof in setup.responses))

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Return the correlation of the worst FRF's residual with frequency squared."""
        return evidence.follows(evidence.freq**2)
