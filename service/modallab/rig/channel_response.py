"""Responses of every run's channels to unit forces, and the latest receptance of a structure."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.fe.cache import CacheSlot
from modallab.rig.run import Run


@dataclass(frozen=True, eq=False)
class ChannelResponse:
    """Responses of every run's channels to a unit force of each source."""

    force: ComplexArray
    """(n_run, n_freq, n_in, n_in) forces per force of the source."""
    response: ComplexArray
    """(n_run, n_freq, n_out, n_in) m/s^2 per N of the source."""
    local_displacement: ComplexArray
    """(n_run, n_freq, r, n_in) m per N of the source, at nonlinear forces."""

    @property
    def channels(self) -> ComplexArray:
        """(n_run, n_freq, n_ch, n_in): forces first."""
        return np.concatenate([self.force, self.response], axis=2)

    @property
    def inertance(self) -> ComplexArray:
        """(n_run, n_freq, n_out, n_in) 1/kg: response over force, as the channels show both."""
        if self.force.shape[-1] == 1:
            return np.asarray(self.response / self.force)
        solved = np.linalg.solve(self.force.swapaxes(2, 3), self.response.swapaxes(2, 3))
        return np.asarray(solved.swapaxes(2, 3))


@dataclass(frozen=True, eq=False)
class CachedReceptance:
    """The latest receptance of a structure at some frequencies, with the runs it belongs to."""

    runs: tuple[Run, ...]
    alpha: ComplexArray

    def matches(self, runs: Sequence[Run]) -> bool:
        """Return whether it is the receptance of these runs."""
        return len(runs) == len(self.runs) and all(map(_same_request, runs, self.runs))


CACHED_RECEPTANCE: CacheSlot[CachedReceptance] = CacheSlot("receptance of the latest runs")


def _same_request(first: Run, second: Run) -> bool:
    first_system, second_system = first.system, second.system
    return (
        first_system.cache is second_system.cache
        and first.motions == second.motions
        and first.n_forces == second.n_forces
        and len(first_system.attachments) == len(second_system.attachments)
        and all(a.equals(b) for a, b in zip(first_system.attachments, second_system.attachments, strict=True))
    )
