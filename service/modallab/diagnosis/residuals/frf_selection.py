"""Selection of FRFs by response and drive point."""

from collections.abc import Sequence
from dataclasses import dataclass

from modallab.core.dof import Dof
from modallab.rig.frf_channel import FrfChannel
from modallab.rig.setup import RigSetup


@dataclass(frozen=True)
class FrfSelection:
    """FRFs of one response, of one drive point, or the one FRF between both."""

    response: Dof | None = None
    """Response, whatever its sense; None: any."""
    drive: Dof | None = None
    """Drive point, whatever its sense; None: any."""

    def selects(self, channel: FrfChannel) -> bool:
        """Return whether an FRF is selected."""
        return all(
            dof is None or dof.point == actual.point
            for dof, actual in ((self.response, channel.response), (self.drive, channel.drive))
        )


def single_frfs(channels: Sequence[FrfChannel], *, roving_hammer: bool) -> tuple[FrfSelection, ...]:
    """Return the selection of each FRF alone: by its response or, with a roving hammer, by both DoFs.

    FRFs of one response to simultaneous forces have one record, and are selected together.
    """
    return tuple(
        FrfSelection(channel.response.point, channel.drive.point if roving_hammer else None)
        for channel in channels
    )


def frfs_at(dof: Dof, setup: RigSetup) -> FrfSelection | None:
    """Return the FRFs that a DoF names: of a point that a roving hammer struck, else of a response.

    None if no FRF belongs to it.
    """
    if setup.roving_hammer and any(drive.point == dof.point for drive in setup.drives):
        return FrfSelection(drive=dof.point)
    measured = any(output.point == dof.point for output in setup.responses)
    return FrfSelection(response=dof.point) if measured else None
