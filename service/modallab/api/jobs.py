"""Jobs: status, event stream and cancellation."""

from collections.abc import AsyncIterator
from functools import partial
from typing import Any

from anyio import sleep, to_thread
from fastapi import APIRouter, status
from starlette.responses import StreamingResponse

from modallab.api import problems
from modallab.api.deps import IdPath, JobsDep, OwnerDep
from modallab.api.limits import JOB_STREAM
from modallab.api.replies import reply
from modallab.jobs.runner import Job, JobRunner, JobState

router = APIRouter(prefix="/jobs", tags=["jobs"])
_EVENTS: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "One event a change",
        "content": {"text/event-stream": {"schema": {"type": "string"}}},
    }
}


JobReply: Any = reply(
    Job,
    "JobStatus",
    leave_out=("owner", "arguments"),
    result_id=(str | None, "Id of the result; null until the job has succeeded."),
    error=(dict[str, Any] | None, "Problem document of a failed job; else null."),
)


def job_reply(job: Job) -> Any:
    """Return the reply of a job."""
    result_id = job.result_id if job.state is JobState.SUCCEEDED else None
    error = None if job.error is None else problems.of_job(job.error)
    return JobReply.model_validate(vars(job) | {"result_id": result_id, "error": error})


@router.get("/{id}", response_model=JobReply, summary="Get a job")
def get_job(id: IdPath, jobs: JobsDep, owner: OwnerDep) -> Any:
    """Return the state and the progress of a job."""
    return job_reply(jobs.get(id, owner=owner))


@router.delete("/{id}", status_code=status.HTTP_200_OK, response_model=JobReply, summary="Cancel a job")
def cancel_job(id: IdPath, jobs: JobsDep, owner: OwnerDep) -> Any:
    """Return a job after asking it to stop; a job that has ended stays as it is."""
    return job_reply(jobs.cancel(id, owner=owner))


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
    return f"data: {job_reply(job).model_dump_json()}\n\n"
