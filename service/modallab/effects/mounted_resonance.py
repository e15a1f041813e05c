"""Mounted resonance of accelerometers."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import NoneType
from typing import ClassVar, Self

import numpy as np

from modallab.core.parameters import parameter
from modallab.core.place import Channels, Place
from modallab.correlation.evidence import Evidence
from modallab.fe.system import DynamicSystem
from modallab.rig.channel import Channel
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.mounting import reading
from modallab.rig.setup import RigSetup


@EFFECTS.register("mounted_resonance")
@dataclass(frozen=True)
class MountedResonance(Effect):
    """Resonance of the accelerometer on its mounting, H' = H/(1 - r^2 + i loss r), r = f/f_0.

    The seismic mass vibrates on the spring of sensing element and mounting. The reading is 12.5 % too high
    at f_0/3 and 4.2 % at f_0/5; rules of thumb state 10 % and 5 %. Serridge and Licht, Piezoelectric
    Accelerometers and Vibration Preamplifiers (1987), chapter 2.
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
        scan_values=(1e3, 2e3, 4e3, 8e3, 16e3, 32e3),
    )
    loss: float = parameter(
        0.05, unit="1", lower=1e-3, upper=1.0, absent=None, doc="twice the damping ratio of the mounting"
    )

    def on_channel(self, channel: Channel, system: DynamicSystem) -> Channel:
        if channel.force or not self.acts_on(channel.dof):
            return channel
        return channel.with_filter(lambda omega: reading(omega / (2 * np.pi * self.frequency), self.loss))

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
