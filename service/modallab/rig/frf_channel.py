"""FRF channels: one per FRF of a test, with its response, its drive point and its run."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import BoolArray, IntArray
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
    """Number of the run, from 0; FRFs of one run share the records of its forces."""

    @property
    def at_drive_point(self) -> bool:
        """Whether force and response are at the same point."""
        return self.response.point == self.drive.point

    def __str__(self) -> str:
        return f"{self.response} / {self.drive}"


def frf_channels(setup: RigSetup) -> tuple[FrfChannel, ...]:
    """Return the FRFs of a test, run by run and in each run force by force."""
    return tuple(
        FrfChannel(response, drive, i)
        for i, acquisition_run in enumerate(setup.acquisition_runs)
        for drive in acquisition_run.drives
        for response in acquisition_run.outputs
    )


def force_numbers(channels: Sequence[FrfChannel]) -> IntArray:
    """Return the number of each FRF's force spectrum, (n_channels,): one for each drive of each run."""
    forces = list(dict.fromkeys((channel.run, channel.drive.point) for channel in channels))
    return np.array([forces.index((channel.run, channel.drive.point)) for channel in channels])


def stands_for_response(channels: Sequence[FrfChannel]) -> BoolArray:
    """Return the FRFs (n_channels,) that are the first of their response in their run.

    Simultaneous forces have one response spectrum in common: it counts once.
    """
    keys = [(channel.run, channel.response.point) for channel in channels]
    return np.array([keys.index(key) == i for i, key in enumerate(keys)])


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
        """Return an array (n_freq, n_out, n_in) as (n_freq, n_channels).

        One of responses alone, (n_freq, n_out), is the same for all forces that act at once.
        """
        rows = list(self.rows)
        return array[:, rows] if array.ndim == 2 else array[:, rows, list(self.columns)]  # 2: a response

    def by_dofs(self, array: NDArray[Any]) -> NDArray[Any]:
        """Return an array (.., n_channels) as (.., n_out, n_in)."""
        shape = max(self.rows) + 1, max(self.columns) + 1
        out = np.zeros((*array.shape[:-1], *shape), array.dtype)
        out[..., list(self.rows), list(self.columns)] = array
        return out
