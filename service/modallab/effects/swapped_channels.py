"""Two exchanged channels."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise
from typing import ClassVar

import numpy as np

from modallab.core.place import Channels, Place
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import MIX_UP
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.channel import Channel
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("swapped_channels")
@dataclass(frozen=True)
class SwappedChannels(Effect):
    """Two exchanged channels, H_1' = H_2 and H_2' = H_1.

    Cause: two exchanged cables, or two lines of the log book. Each FRF is correct except for its name. The
    motions are exchanged, and the places of a roving accelerometer's mass; other errors of a channel stay
    with the name. Reciprocal FRFs no longer agree: Rayleigh, The Theory of Sound (1894), chapter V.
    """

    kind: ClassVar[str] = "swapped_channels"
    summary: ClassVar[str] = "two exchanged channels"
    stage: ClassVar[Stage] = Stage.CHANNEL
    allowed_places: ClassVar[tuple[type, ...]] = (Channels,)

    def on_run(self, acquisition_run: AcquisitionRun) -> AcquisitionRun:
        channels = self.at.dofs if isinstance(self.at, Channels) else ()
        present = {dof.node for dof in acquisition_run.outputs if self.acts_on(dof)}
        absent = {dof.node for dof in channels} - present
        if len(present) != 1 or len(absent) != 1:
            return acquisition_run
        point = min(present), (min(absent), 0.0)
        displaced = (*acquisition_run.displaced_accelerometers, point)
        return replace(acquisition_run, displaced_accelerometers=displaced)

    def on_channel(self, channel: Channel, system: DynamicSystem) -> Channel:
        if channel.force or not self.acts_on(channel.dof):
            return channel
        channels = self.at.dofs if isinstance(self.at, Channels) else ()
        partner = [dof for dof in channels if dof.point != channel.dof.point]
        if len(partner) != 1:
            raise self._misplaced("two channels")
        return channel.with_pickup(channel.dof, -1.0).with_pickup(partner[0], 1.0)

    def check(self, structure: Structure, setup: RigSetup | None = None) -> None:
        """Raise unless it names two channels, each with the sense it has in the log book."""
        super().check(structure, setup)
        dofs = self.at.dofs if isinstance(self.at, Channels) else ()
        if len({dof.point for dof in dofs}) != 2 or len(dofs) != 2:
            raise self._misplaced("two channels")
        if setup is not None and any(dof not in setup.responses for dof in dofs):
            raise self._misplaced([str(dof) for dof in setup.responses])

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return every pair; of very many channels neighbours in the log book alone."""
        few = len(setup.responses) <= MIX_UP.paired_channels
        pairs = combinations(setup.responses, 2) if few else pairwise(setup.responses)
        return tuple(Channels(pair) for pair in pairs)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Two FRFs disagree, the others do not."""
        channel = np.sort(evidence.by_channel)
        if len(channel) < 2:
            return 0.0
        median_channel = float(np.median(channel[:-2])) if len(channel) > 2 else 0.0
        return float(np.clip(1 - median_channel / max(float(channel[-2]), 1.0), 0.0, 1.0))
