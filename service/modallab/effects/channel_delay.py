"""Time delay of a channel."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import NoneType
from typing import ClassVar

import numpy as np

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Channels, Place
from modallab.correlation.evidence import Evidence
from modallab.fe.system import DynamicSystem
from modallab.rig.channel import Channel
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import RigSetup


@EFFECTS.register("channel_delay")
@dataclass(frozen=True)
class ChannelDelay(Effect):
    """Delay of one channel against the others, H' = H exp(-i omega tau), by sampling or anti-alias filter.

    A delay common to all channels cancels. A difference changes the phase of an FRF in proportion to
    frequency, and with it the apparent damping of high modes. With the place null: all responses after the
    force; with a DoF: the force transducer there. A negative delay means early. Bendat and Piersol, Random
    Data (2010), section 5.1.
    """

    kind: ClassVar[str] = "channel_delay"
    summary: ClassVar[str] = "constant delay of a channel against the others"
    stage: ClassVar[Stage] = Stage.CHANNEL
    tolerance: ClassVar[str | None] = "delay"
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Channels, Dof)
    at_drive: ClassVar[bool] = True
    delay: float = parameter(
        1e-5,
        unit="s",
        lower=-1e-2,
        upper=1e-2,
        doc="delay of the channel, negative: early",
        scan_values=(-1e-3, -1e-4, -1e-5, -1e-6, 1e-6, 1e-5, 1e-4, 1e-3),
    )

    def on_channel(self, channel: Channel, system: DynamicSystem) -> Channel:
        if not self.acts_on_channel(channel):
            return channel
        return channel.with_filter(lambda omega: np.exp(-1j * omega * self.delay))

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return all responses, each, and each force where there are several."""
        forces = tuple(dof.point for dof in setup.drives) if len(setup.drives) > 1 else ()
        return (None, *forces, *(Channels((dof,)) for dof in setup.responses))

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Return the correlation of the worst FRF's residual with a phase error proportional to frequency."""
        return evidence.follows(np.asarray(1j * evidence.freq))
