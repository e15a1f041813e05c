"""FRF channels: one per FRF of a test, with its response, its drive point and its run."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.dof import Dof
from modallab.rig.setup import RigSetup


@dataclass(frozen=True)
class FrfChannel:
    """One FRF of a test: the response, the force, and the run in which both were recorded."""

    response: Dof
    """Response DoF."""
    drive: Dof
    """DoF of the force."""
    run: int
    """Number of the run, from 0; FRFs of one run share the record of the force."""

    @property
    def at_drive_point(self) -> bool:
        """Whether force and response are at the same point."""
        return self.response.point == self.drive.point

    def __str__(self) -> str:
        return f"{self.response} / {self.drive}"


def frf_channels(setup: RigSetup) -> tuple[FrfChannel, ...]:
    """Return the FRFs of a test with one force a run, run by run."""
    return tuple(
        FrfChannel(response, acquisition_run.drive, i)
        for i, acquisition_run in enumerate(setup.acquisition_runs)
        for response in acquisition_run.outputs
    )


@dataclass(frozen=True)
class FrfLayout:
    """Places of the FRF channels in arrays by response and drive point."""

    channels: tuple[FrfChannel, ...]
    """FRFs, n_channels of them."""
    rows: tuple[int, ...]
    """Number of the response of each channel."""
    columns: tuple[int, ...]
    """Number of the drive point of each channel."""

    @classmethod
    def of(cls, channels: Sequence[FrfChannel], outputs: Sequence[Dof], inputs: Sequence[Dof]) -> "FrfLayout":
        """Return the places of channels in arrays (.., n_out, n_in)."""
        rows, columns = ({dof.point: i for i, dof in enumerate(dofs)} for dofs in (outputs, inputs))
        return cls(
            tuple(channels),
            tuple(rows[channel.response.point] for channel in channels),
            tuple(columns[channel.drive.point] for channel in channels),
        )

    def by_channel(self, array: NDArray[Any]) -> NDArray[Any]:
        """Return an array (n_freq, n_out, n_in), or (n_freq, n_out) of one input, as (n_freq, n_channels)."""
        values = array[..., None] if array.ndim == 2 else array  # 2: one value a response
        return values[:, list(self.rows), list(self.columns)]

    def by_dofs(self, array: NDArray[Any]) -> NDArray[Any]:
        """Return an array (.., n_channels) as (.., n_out, n_in)."""
        shape = max(self.rows) + 1, max(self.columns) + 1
        out = np.zeros((*array.shape[:-1], *shape), array.dtype)
        out[..., list(self.rows), list(self.columns)] = array
        return out
