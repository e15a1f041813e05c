"""Transverse sensitivity of accelerometers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import NoneType
from typing import ClassVar, Self

import numpy as np

from modallab.core.dof import TRANSLATIONS, Dof
from modallab.core.parameters import parameter
from modallab.core.place import Channels, Place
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import TRANSVERSE_SCAN
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.channel import Channel
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import RigSetup


def _across(dof: Dof) -> tuple[Dof, Dof]:
    first, second = (direction for direction in TRANSLATIONS if direction != dof.direction)
    return Dof(dof.node, first), Dof(dof.node, second)


@EFFECTS.register("transverse_sensitivity")
@dataclass(frozen=True)
class TransverseSensitivity(Effect):
    """Sensitivity to motion across the axis, a' = a + s (cos(angle) a_t + sin(angle) a_u).

    t and u are the other two translations of the node in the order X, Y, Z, positive along the axes of the
    structure. Translations that the structure does not have are 0, so that in a plane frame only s
    cos(angle) matters: there a diagnosis leaves the angle at 0. Reciprocal FRFs no longer agree. ISO 16063-31
    describes the measurement of s and the angle; a good accelerometer has 0.01 to 0.05.
    """

    kind: ClassVar[str] = "transverse_sensitivity"
    summary: ClassVar[str] = "accelerometer measures motion across its axis, too"
    stage: ClassVar[Stage] = Stage.CHANNEL
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Channels)
    sensitivity: float = parameter(
        0.03,
        unit="1",
        lower=-1.0,
        upper=1.0,
        doc="across the axis over along it",
        scan_values=(-0.1, -0.01, 0.01, 0.1),
    )
    angle: float = parameter(
        0.0,
        unit="rad",
        lower=-np.pi / 2,
        upper=np.pi / 2,
        absent=None,
        doc="about the axis, to the most sensitive direction",
        optional_start=TRANSVERSE_SCAN.angle,
    )

    def on_channel(self, channel: Channel, system: DynamicSystem) -> Channel:
        if channel.force or not self.acts_on(channel.dof):
            return channel
        shares = self.sensitivity * np.array([np.cos(self.angle), np.sin(self.angle)])
        for dof, share in zip(_across(channel.dof), shares, strict=True):
            if dof in system.dofs:
                channel = channel.with_pickup(dof, float(share))
        return channel

    def scan_values(self, system: DynamicSystem, setup: RigSetup) -> Mapping[str, Sequence[float]]:
        """Return angles of structures that move in both directions across an axis."""
        dofs = set(system.dofs)
        in_space = any(dofs.issuperset(_across(dof)) for dof in setup.responses)
        return {"angle": (0.0, TRANSVERSE_SCAN.angle, -TRANSVERSE_SCAN.angle)} if in_space else {}

    def check(self, structure: Structure, setup: RigSetup | None = None) -> None:
        """Raise unless there is motion across the axis of a channel it sits at."""
        super().check(structure, setup)
        channels = self.at.dofs if isinstance(self.at, Channels) else setup.responses if setup else ()
        if channels and not any(lateral in structure.dofs for dof in channels for lateral in _across(dof)):
            raise self._misplaced("channels of nodes that move across the channel's axis as well")

    @classmethod
    def from_setup(cls, setup: RigSetup) -> Sequence[Self]:
        used = setup.accelerometers
        if used.transverse_sensitivity == 0:
            return []
        return [cls(sensitivity=used.transverse_sensitivity, angle=used.transverse_angle)]

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return the channels of nodes that move across the channel's axis as well, together and each."""
        dofs = set(system.dofs)
        places_of_channels = [
            Channels((dof,)) for dof in setup.responses if not dofs.isdisjoint(_across(dof))
        ]
        return (None, *places_of_channels) if places_of_channels else ()

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """One FRF stands out, most where the motion along its axis is small."""
        return 0.5 * evidence.standing_out
