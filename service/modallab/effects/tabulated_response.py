"""Tabulated response: a channel whose gain is a curve over frequency."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import NoneType
from typing import ClassVar

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.frequency_table import FrequencyTable
from modallab.core.parameters import parameter
from modallab.core.place import Channels, Place, TableRow
from modallab.correlation.evidence import Evidence
from modallab.fe.system import DynamicSystem
from modallab.rig.channel import Channel
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import RigSetup


@EFFECTS.register("tabulated_response")
@dataclass(frozen=True)
class TabulatedResponse(Effect):
    """Gain of a response channel that a table gives, H' = (1 + s (g(f) - 1)) H.

    `table` holds rows of frequency, Hz, real and imaginary part of the gain g, true over declared; between
    them g is a cubic spline, beyond them constant. With the place null it is the gain of all responses. A
    calibration over frequency gives such a curve: ISO 16063-21 (2003), Vibration calibration by comparison
    to a reference transducer.
    """

    kind: ClassVar[str] = "tabulated_response"
    summary: ClassVar[str] = "channel whose gain is a curve over frequency"
    stage: ClassVar[Stage] = Stage.CHANNEL
    suspected: ClassVar[bool] = False
    tabulated: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Channels)
    scale: float = parameter(
        1.0, unit="1", lower=-100.0, upper=100.0, doc="factor of the deviation of the tabulated gain from 1"
    )
    table: tuple[TableRow, ...] = ((0.0, 1.0, 0.0), (200.0, 1.1, 0.1))

    def __post_init__(self) -> None:
        super().__post_init__()
        FrequencyTable(self.table)

    def on_channel(self, channel: Channel, system: DynamicSystem) -> Channel:
        if channel.force or not self.acts_on_channel(channel):
            return channel
        return channel.with_filter(self._gain)

    def _gain(self, omega: FloatArray) -> ComplexArray:
        return np.asarray(1 + self.scale * (FrequencyTable(self.table).at(omega / (2 * np.pi)) - 1))

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        return (None, *(Channels((d,)) for d in setup.responses))

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Return a low suspicion: a curve can imitate anything in its channel."""
        return 0.1
