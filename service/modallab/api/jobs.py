"""Jobs: how far they are, as a reply or as a stream, and how to stop them."""

from collections.abc import AsyncIterator
from functools import partial
from typing import Any, Self

from anyio import sleep, to_thread
from fastapi import APIRouter, status
from starlette.responses import StreamingResponse

from modallab.api import problems
from modallab.api.deps import IdPath, JobsDep, OwnerDep
from modallab.api.limits import JOB_STREAM
from modallab.api.wire import Reply
from modallab.jobs.runner import Job, JobRunner, JobState

router = APIRouter(prefix="/jobs", tags=["jobs"])
_EVENTS: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "One event a change",
        "content": {"text/event-stream": {"schema": {"type": "string"}}},
    }
}


class JobOut(Reply):
    """A job; `result_id` is the id of what it made, `error` the problem that stopped it."""

    id: str
    """id of the job"""
    state: JobState
    """state of the job"""
    fraction: float
    """1, share of the work that is done, 0 to 1"""
    message: str
    """step that is under way"""
    result_id: str | None
    """id of the result; null until the job has succeeded"""
    error: dict[str, Any] | None
    """problem that ended a failed job"""

    @classmethod
    def of(cls, job: Job) -> Self:
        """Return what the contract shows of a job."""
        succeeded = job.state is JobState.SUCCEEDED
        return cls(
            id=job.id,
            state=job.state,
            fraction=job.fraction,
            message=job.message,
            result_id=job.result_id if succeeded else None,
            error=None if job.error is None else problems.of_job(job.error),
        )


@router.get("/{id}", summary="Get a job")
def get_job(id: IdPath, jobs: JobsDep, owner: OwnerDep) -> JobOut:
    """Return the state and the progress of a job."""
    return JobOut.of(jobs.get(id, owner=owner))


@router.delete("/{id}", status_code=status.HTTP_200_OK, summary="Cancel a job")
def cancel_job(id: IdPath, jobs: JobsDep, owner: OwnerDep) -> JobOut:
    """Return a job after asking it to stop; a job that has ended stays as it is."""
    return JobOut.of(jobs.cancel(id, owner=owner))


@router.get("/{id}/events", response_class=StreamingResponse, responses=_EVENTS, summary="Follow a job")
async def stream_job(id: IdPath, jobs: JobsDep, owner: OwnerDep) -> StreamingResponse:
    """Return a stream of server-sent events, one a change, each with the job as JSON."""
    first = await to_thread.run_sync(partial(jobs.get, id, owner=owner))  # an unknown id is a 404, no stream
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    return StreamingResponse(_events(jobs, first), media_type="text/event-stream", headers=headers)


async def _events(jobs: JobRunner, job: Job) -> AsyncIterator[str]:
    look = partial(jobs.get, job.id, owner=job.owner)
    yield _event(job)
    silent = 0.0
    while not job.state.final:
        await sleep(JOB_STREAM.polling_interval)
        silent += JOB_STREAM.polling_interval
        previous, job = job, await to_thread.run_sync(look)
        if job != previous:
            silent = 0.0
            yield _event(job)
        elif silent >= JOB_STREAM.keep_alive:
            silent = 0.0
            yield ": still here\n\n"


def _event(job: Job) -> str:
    return f"data: {JobOut.of(job).model_dump_json()}\n\n"
