"""Sensitivity error of a channel."""

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


@EFFECTS.register("gain_error")
@dataclass(frozen=True)
class GainError(Effect):
    """Wrong sensitivity or unit of a channel, H' = factor H.

    A reading in mm/s^2 that the log book takes for m/s^2 has a factor of 1000, one in g 0.102. With a DoF as
    place: the force transducer there, which divides every FRF by the factor. Frequencies, damping and
    coherence do not change; modal constants do. Ewins, Modal Testing (2000), section 3.10, on calibration.
    """

    kind: ClassVar[str] = "gain_error"
    summary: ClassVar[str] = "sensitivity of a channel differs from the declared one"
    stage: ClassVar[Stage] = Stage.CHANNEL
    tolerance: ClassVar[str | None] = "sensitivity"
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Channels, Dof)
    at_drive: ClassVar[bool] = True
    factor: float = parameter(
        1.1,
        unit="1",
        lower=1e-4,
        upper=1e4,
        absent=1.0,
        doc="measured over true value",
        scan_values=(0.1, 0.5, 0.9, 0.99, 1.01, 1.1, 2.0, 10.0),
    )

    def on_channel(self, channel: Channel, system: DynamicSystem) -> Channel:
        if not self.acts_on_channel(channel):
            return channel
        return channel.with_filter(lambda omega: np.full(len(omega), self.factor, complex))

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        return (None, *(d.point for d in setup.drives), *(Channels((d,)) for d in setup.responses))

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Return the correlation of the worst FRF's residual with a constant factor."""
        return evidence.follows(np.ones(len(evidence.freq)))
