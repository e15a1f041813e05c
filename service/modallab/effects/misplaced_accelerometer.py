"""Accelerometer beside its declared node."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from modallab.core.parameters import parameter
from modallab.core.place import Channels, Place
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import MIX_UP
from modallab.fe.interpolation import point_motion
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.channel import Channel
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup

_ALLOWED_CHANNELS = "channels at nodes of bars, whose shape says how a point beside the node moves"


@EFFECTS.register("misplaced_accelerometer")
@dataclass(frozen=True)
class MisplacedAccelerometer(Effect):
    """Accelerometer beside its node: the reading is that of another point of the member, a' = N(distance) q.

    N are the shape functions of the member, q the motion of its ends: linear along the member and cubic
    across it, Przemieniecki, Theory of Matrix Structural Analysis (1968), section 5.6; beyond a free end
    the sensor is on a rigid arm. The error is largest for modes with short wavelengths. Its mass is at that
    point too.
    """

    kind: ClassVar[str] = "misplaced_accelerometer"
    summary: ClassVar[str] = "accelerometer beside the node that the log book names"
    stage: ClassVar[Stage] = Stage.CHANNEL
    allowed_places: ClassVar[tuple[type, ...]] = (Channels,)
    distance: float = parameter(
        0.01,
        unit="m",
        lower=-1.0,
        upper=1.0,
        doc="along the member that starts at the node; negative: back along the one that ends there",
    )

    def on_run(self, acquisition_run: AcquisitionRun) -> AcquisitionRun:
        nodes = {dof.node for dof in acquisition_run.outputs if self.acts_on(dof)}
        points = ((node, (node, self.distance)) for node in sorted(nodes))
        displaced = (*acquisition_run.displaced_accelerometers, *points)
        return replace(acquisition_run, displaced_accelerometers=displaced)

    def on_channel(self, channel: Channel, system: DynamicSystem) -> Channel:
        if channel.force or system.members is None or not self.acts_on(channel.dof):
            return channel
        dof = channel.dof
        if not system.members.has_bar(dof.node):
            raise self._misplaced(_ALLOWED_CHANNELS)
        channel = channel.with_pickup(dof, -1.0)
        for row, weight in point_motion(system.members, dof.node, self.distance, dof.direction):
            channel = channel.with_pickup(system.dofs[row], dof.sign * weight)
        return channel

    def check(self, structure: Structure, setup: RigSetup | None = None) -> None:
        """Raise unless its channels are at nodes of bars; see `Effect.check`."""
        super().check(structure, setup)
        channels = self.at.dofs if isinstance(self.at, Channels) else ()
        nodes = {node for m in structure.members for node in m.nodes}
        if any(dof.node in structure.nodes and dof.node not in nodes for dof in channels):
            raise self._misplaced(_ALLOWED_CHANNELS)

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return the channels at nodes of bars, each."""
        table = system.members
        return tuple(Channels((dof,)) for dof in setup.responses if table and table.has_bar(dof.node))

    def scan_values(self, system: DynamicSystem, setup: RigSetup) -> Mapping[str, Sequence[float]]:
        """Return distances in both directions: small ones, and parts and multiples of a member's length.

        Not those to points that cannot move, where an accelerometer has no signal.
        """
        table = system.members
        dofs = self.at.dofs if isinstance(self.at, Channels) else ()
        if table is None or not dofs:
            return {}
        length = float(np.mean([length for dof in dofs for length in table.bar_lengths(dof.node)]))
        sizes = [share * length for share in MIX_UP.misplacements]
        highest = self.specs()["distance"].upper
        distances = [d for d in (*(-size for size in reversed(sizes)), *sizes) if abs(d) <= highest]
        moving = [
            distance
            for distance in distances
            if all(
                any(weight for _, weight in point_motion(table, dof.node, distance, dof.direction))
                for dof in dofs
            )
        ]
        return {"distance": moving}

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """One FRF stands out from the others."""
        return 0.7 * evidence.standing_out
