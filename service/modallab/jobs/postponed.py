"""Ends of jobs that are told later than their work is done, so that the time tells nothing of the work.

The book has such a job as running, without a process that works on it, until whoever reconciles ends it.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime, timedelta

from modallab.core.errors import ModalLabError


@dataclass(frozen=True)
class Postponed:
    """What a task returns whose end is told later."""

    least: float
    """s, time from the beginning of the job to its end, at least."""
    step: float
    """s, of which that time is a multiple; 0: of any."""
    error: ModalLabError | None = None
    """Error that the job ends with; None: it ends well."""

    def due(self, started: str, now: datetime) -> datetime:
        """Return the time of the end.

        Parameters
        ----------
        started
            ISO 8601, time at which the job began.
        now
            Time at which the work is done.
        """
        began = datetime.fromisoformat(started)
        elapsed = max((now - began).total_seconds(), self.least)
        if self.step == 0:
            return began + timedelta(seconds=elapsed)
        return began + timedelta(seconds=self.step * math.ceil(elapsed / self.step))


@dataclass(frozen=True)
class DueJob:
    """A job that only its end is left of."""

    id: str
    started: str
    """ISO 8601, time at which it began."""
    due: str
    """ISO 8601, time of its end."""
    active: bool
    """Whether it has to end still: it may have been cancelled."""
    good: bool
    """Whether it has a result."""

    def rest(self, now: datetime) -> float:
        """Return the time until the end, s; never more than all of the job, whatever the clock was set to."""
        began, due = datetime.fromisoformat(self.started), datetime.fromisoformat(self.due)
        return min((due - now).total_seconds(), (due - began).total_seconds()) if self.active else 0.0


@dataclass
class Timer:
    """Tells which jobs have to end, by a clock that is never set."""

    clock: Callable[[], float] = time.monotonic
    _ends: dict[str, float] = field(default_factory=dict)

    def over(self, jobs: list[DueJob], now: datetime) -> list[DueJob]:
        """Return the jobs whose time has come, of all that are due."""
        at = self.clock()
        # A job that was seen before keeps its end: the time of day may have been set since.
        self._ends = {job.id: self._ends.get(job.id, at + job.rest(now)) for job in jobs}
        return [job for job in jobs if not job.active or self._ends[job.id] <= at]
