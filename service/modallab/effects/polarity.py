"""Reversed sign of a channel."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import NoneType
from typing import ClassVar

import numpy as np

from modallab.core.dof import Dof
from modallab.core.place import Channels, Place
from modallab.correlation.evidence import Evidence
from modallab.fe.system import DynamicSystem
from modallab.rig.channel import Channel
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import RigSetup


@EFFECTS.register("polarity")
@dataclass(frozen=True)
class Polarity(Effect):
    """Reversed sign of a channel, H' = -H: reversed direction of a sensor, or exchanged wires.

    The phase of the FRF changes by pi; auto spectra and coherence do not change. With the place null: all
    responses, which is equivalent to the force transducer. With a DoF: the force transducer there, in a
    test with several forces. The imaginary part of the drive point inertance has a known sign, because a
    passive structure only absorbs power (Cremer and Heckl, Structure-Borne Sound, 1973, chapter IV).
    """

    kind: ClassVar[str] = "polarity"
    summary: ClassVar[str] = "reversed sign of a channel"
    stage: ClassVar[Stage] = Stage.CHANNEL
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Channels, Dof)
    at_drive: ClassVar[bool] = True

    def on_channel(self, channel: Channel, system: DynamicSystem) -> Channel:
        if not self.acts_on_channel(channel):
            return channel
        return channel.with_filter(lambda omega: np.full(len(omega), -1.0 + 0j))

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return all responses, each, and each force where there are several."""
        forces = tuple(dof.point for dof in setup.drives) if len(setup.drives) > 1 else ()
        return (None, *forces, *(Channels((dof,)) for dof in setup.responses))

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Return the evidence of a wrong phase at the right magnitude in the worst FRF."""
        worst = int(evidence.by_channel.argmax())
        residual = evidence.frf[:, worst] * evidence.weight[:, worst]
        size = float((np.abs(residual) ** 2).sum())
        return min(1.0, float((residual.imag**2).sum()) / size) if size > 0 else 0.0
