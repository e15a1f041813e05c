"""Effects that no catalogue holds: what a diagnosis can only call unexplained."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Channels, Place
from modallab.fe.system import DynamicSystem
from modallab.rig.channel import Channel
from modallab.rig.effect import Effect, Stage
from modallab.rig.local_force import LocalForce
from modallab.rig.setup import RigSetup


@dataclass(frozen=True)
class GainBump(Effect):
    """A channel reads too high in one stretch of the band: 1 + height exp(-(f - centre)^2 / width^2)."""

    kind: ClassVar[str] = "gain_bump"
    summary: ClassVar[str] = "a channel's sensitivity has a bump"
    stage: ClassVar[Stage] = Stage.CHANNEL
    allowed_places: ClassVar[tuple[type, ...]] = (Channels,)
    height: float = parameter(0.1, unit="1", lower=0.0, upper=10.0, doc="at its centre")
    centre: float = parameter(300.0, unit="Hz", lower=1.0, upper=1e5, absent=None, doc="of the bump")
    width: float = parameter(60.0, unit="Hz", lower=1.0, upper=1e5, absent=None, doc="of the bump")

    def on_channel(self, channel: Channel, system: DynamicSystem) -> Channel:
        """See `Effect.on_channel`."""
        if channel.force or not self.acts_on(channel.dof):
            return channel
        return channel.with_filter(self._reading)

    def _reading(self, omega: FloatArray) -> ComplexArray:
        off = (omega / (2 * np.pi) - self.centre) / self.width
        return np.asarray(1 + self.height * np.exp(-(off**2)) + 0j)

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> tuple[Place, ...]:
        """Return every channel."""
        return tuple(Channels((dof,)) for dof in setup.responses)


@dataclass(frozen=True)
class Echo(Effect):
    """All responses come once more, later and smaller, as data folded in time do: 1 + r exp(-i omega tau)."""

    kind: ClassVar[str] = "echo"
    summary: ClassVar[str] = "responses come a second time"
    stage: ClassVar[Stage] = Stage.CHANNEL
    ratio: float = parameter(0.05, unit="1", lower=0.0, upper=0.9, doc="of the second to the first")
    delay: float = parameter(0.02, unit="s", lower=1e-6, upper=10.0, absent=None, doc="of the second")

    def on_channel(self, channel: Channel, system: DynamicSystem) -> Channel:
        """See `Effect.on_channel`."""
        if channel.force:
            return channel
        return channel.with_filter(lambda omega: 1 + self.ratio * np.exp(-1j * omega * self.delay))


@dataclass(frozen=True)
class CubicDamper(Effect):
    """f = c v^3 from one DoF to the ground."""

    kind: ClassVar[str] = "cubic_damper"
    summary: ClassVar[str] = "a damper that grows with the cube of velocity"
    stage: ClassVar[Stage] = Stage.MOTION
    structural: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (Dof,)
    damping: float = parameter(1e3, unit="N s^3/m^3", lower=0.0, upper=1e20, doc="force over velocity cubed")

    def on_motion(self) -> LocalForce | None:
        """See `Effect.on_motion`."""
        assert isinstance(self.at, Dof)
        c = self.damping
        if c == 0:
            return None
        return LocalForce(self.at, lambda v: c * v**3, lambda v: 3 * c * v**2, of_velocity=True)

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> tuple[Place, ...]:
        """Return every response."""
        return tuple(dof.point for dof in setup.responses)


FOREIGN: dict[str, type[Effect]] = {cls.kind: cls for cls in (GainBump, Echo, CubicDamper)}
