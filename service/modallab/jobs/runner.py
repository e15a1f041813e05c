"""Jobs as their owners see them, and the interface of their runners."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Protocol, Self

from modallab.core.errors import ModalLabError
from modallab.jobs.settings import JOB
from modallab.store.viewer import Viewer


class JobState(StrEnum):
    """State of a job."""

    QUEUED = "queued"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELLED = "cancelled"

    @property
    def final(self) -> bool:
        """True when nothing will change any more."""
        return self not in (JobState.QUEUED, JobState.RUNNING)


class Lane(StrEnum):
    """Part of the queue that a job waits in: long jobs never hold back short ones."""

    SHORT = "short"
    LONG = "long"


@dataclass(frozen=True)
class Job:
    """Status of a background task."""

    id: str
    """Id of the job."""
    owner: str
    """Owner of the job and of its result."""
    task: str
    """Name of the task, for example `measure_and_store`."""
    arguments: Mapping[str, Any]
    """Arguments of the task as JSON values."""
    created: str
    """ISO 8601, UTC, time of the request."""
    state: JobState
    """State of the job."""
    fraction: float
    """1, share of the work that is done, 0 to 1."""
    message: str
    """Step under way."""
    result_id: str
    """Id of the result, fixed before the task starts."""
    error: Mapping[str, Any] | None = None
    """Code, title, detail and context of the error that ended the job; None: no error."""
    started: str | None = None
    """ISO 8601, UTC, time at which the work began; None: it waits."""
    ended: str | None = None
    """ISO 8601, UTC, time of the end; None: the job has not ended."""
    lane: Lane = Lane.LONG
    """Part of the queue, by the estimated duration of the job."""
    turn: int = 0
    """1, number of the owner's turn in the lane."""
    place: int | None = None
    """1, place in its lane of the queue, 1 for the next; None: the job does not wait."""
    wait_estimate: float | None = None
    """s, time until the work may begin, by recent jobs; None: the job does not wait, or nothing is known."""


@dataclass(frozen=True)
class RequestKey:
    """Name that a caller gives a request, so that its repetition starts nothing twice."""

    key: str
    """Name, unique among the requests of an owner."""
    digest: str
    """SHA-256 of the request."""


class KeyReusedError(ModalLabError):
    """A key that another request has had already."""

    code = "key_reused"


class QueueFullError(ModalLabError):
    """As many jobs wait as may; try again later."""

    code = "queue_full"


class QueueQuotaError(ModalLabError):
    """As many jobs of a key, or of a class, wait as may; try again later."""

    code = "queue_quota"


class TimeLimitError(ModalLabError):
    """A job took longer than one may."""

    code = "time_limit"


def time_limit_error() -> TimeLimitError:
    """Return the error of a job that took too long."""
    hours = JOB.time_limit / 3600
    return TimeLimitError(f"the job took longer than {hours:g} hours", allowed=f"{JOB.time_limit:g} s")


class NotReadyError(ModalLabError):
    """Something that the service needs is missing."""

    code = "not_ready"


class JobRunner(Protocol):
    """Runs tasks out of the request's way; used as an asynchronous context."""

    async def __aenter__(self) -> Self:
        """Start to take and to run jobs, those left over from before included."""
        ...

    async def __aexit__(self, *exception: object) -> None:
        """Stop; jobs under way go on at the next start."""
        ...

    def submit(
        self,
        task: str,
        arguments: Mapping[str, Any],
        *,
        owner: str,
        lane: Lane = Lane.LONG,
        request: RequestKey | None = None,
    ) -> Job:
        """Queue a task of `jobs.tasks` and return its job; that of the same request if there was one.

        Raises
        ------
        QueueFullError, QueueQuotaError
            If too many wait, of all or of the owner and the class.
        KeyReusedError
            If another request of the owner had the key.
        """
        ...

    def get(self, job_id: str, *, viewer: Viewer) -> Job:
        """Return a job; `NotFoundError` if it is not there for the viewer."""
        ...

    def is_served(self) -> bool:
        """Return whether a process lives that runs jobs."""
        ...

    def find(
        self,
        *,
        viewer: Viewer,
        owner: str | None,
        state: JobState | None,
        task: str | None,
        limit: int,
        cursor: str | None,
    ) -> list[Job]:
        """Return the newest jobs that exist for a viewer, those of an owner if named, before `cursor`."""
        ...

    def cancel(self, job_id: str, *, viewer: Viewer) -> Job:
        """Stop a job and return it; a job that has ended stays as it is."""
        ...
