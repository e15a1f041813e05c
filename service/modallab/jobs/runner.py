"""Jobs as their owners see them, and what may run them."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Protocol, Self

from modallab.core.errors import ModalLabError


class JobState(StrEnum):
    """How far a job is."""

    QUEUED = "queued"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELLED = "cancelled"

    @property
    def final(self) -> bool:
        """True when nothing will change any more."""
        return self not in (JobState.QUEUED, JobState.RUNNING)


@dataclass(frozen=True)
class Job:
    """Long work by name; `arguments` are JSON values, `result_id` is fixed before it starts."""

    id: str
    owner: str
    task: str
    arguments: Mapping[str, Any]
    created: str  # ISO 8601, UTC
    state: JobState
    fraction: float
    message: str
    result_id: str
    error: Mapping[str, Any] | None = None  # code, title, detail, context


class QueueFullError(ModalLabError):
    """As many jobs wait as may; try again later."""

    code = "queue_full"


class JobRunner(Protocol):
    """Runs tasks out of the request's way; used as an asynchronous context."""

    async def __aenter__(self) -> Self:
        """Start to take and to run jobs, those left over from before included."""
        ...

    async def __aexit__(self, *exception: object) -> None:
        """Stop; jobs under way go on at the next start."""
        ...

    def submit(self, task: str, arguments: Mapping[str, Any], *, owner: str) -> Job:
        """Queue a task of `jobs.tasks` and return its job; `QueueFullError` if too many wait."""
        ...

    def get(self, job_id: str, *, owner: str) -> Job:
        """Return a job of an owner; `NotFoundError` if there is none."""
        ...

    def cancel(self, job_id: str, *, owner: str) -> Job:
        """Stop a job and return it; a job that has ended stays as it is."""
        ...
