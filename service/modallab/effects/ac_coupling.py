"""AC coupling: high-pass of a channel."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import NoneType
from typing import ClassVar, Self

import numpy as np

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
from modallab.core.place import Channels, Place
from modallab.correlation.evidence import Evidence
from modallab.fe.system import DynamicSystem
from modallab.rig.channel import Channel
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import RigSetup


@EFFECTS.register("ac_coupling")
@dataclass(frozen=True)
class AcCoupling(Effect):
    """First-order high-pass of an AC-coupled input or of a sensor, H' = H / (1 - i f_c/f).

    The time constant is tau = 1/(2 pi f_c). If the force transducer has another corner frequency than the
    accelerometers, the phase of every FRF is wrong at low frequencies; equal corners cancel in the FRF and
    remain in the auto spectra. With the place null the effect acts on all responses, with a DoF on the
    force transducer there. An analyser declared as AC-coupled has both. Serridge and Licht, Piezoelectric
    Accelerometers and Vibration Preamplifiers (1987), on lower limiting frequencies.
    """

    kind: ClassVar[str] = "ac_coupling"
    summary: ClassVar[str] = "high-pass filter of a channel reduces the lowest frequencies"
    stage: ClassVar[Stage] = Stage.CHANNEL
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Channels, Dof)
    at_drive: ClassVar[bool] = True
    corner: float = parameter(
        1.0,
        unit="Hz",
        lower=0.0,
        upper=1e4,
        doc="frequency at which the reading is 3 dB down",
        scan_values=(0.01, 0.1, 1.0, 10.0),
    )

    def on_channel(self, channel: Channel, system: DynamicSystem) -> Channel:
        if not self.acts_on_channel(channel):
            return channel
        return channel.with_filter(lambda omega: np.asarray(1 / (1 - 2j * np.pi * self.corner / omega)))

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        analyser = setup.analyser
        if analyser.coupling == "dc":
            return []
        return [cls(at=at, corner=analyser.coupling_frequency) for at in (None, *setup.drives)]

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        return (None, *(d.point for d in setup.drives), *(Channels((d,)) for d in setup.responses))

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Return the correlation of the worst residual with a phase error proportional to the period."""
        slow = np.divide(1.0, evidence.freq, out=np.zeros(len(evidence.freq)), where=evidence.freq > 0)
        return evidence.follows(np.asarray(1j * slow))
