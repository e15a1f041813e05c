"""Jobs: status, event stream and cancellation."""

from collections.abc import AsyncIterator, Callable
from functools import partial
from hashlib import sha256
from typing import Annotated, Any, Literal

from anyio import sleep, to_thread
from fastapi import APIRouter, Header, Query, status
from starlette.responses import StreamingResponse

from modallab.api import problems
from modallab.api.access import Verify, VerifyDep
from modallab.api.deps import After, IdPath, JobsDep, Limit, OwnerWanted, ViewerDep
from modallab.api.limits import JOB_STREAM
from modallab.api.replies import reply
from modallab.api.wire import Reply
from modallab.jobs.runner import Job, JobState
from modallab.jobs.tasks import DIAGNOSIS, EXTRACTION, MEASUREMENT, SEALED_MEASUREMENT, STUDY, UPDATE
from modallab.store.base import UnauthorisedError

router = APIRouter(prefix="/jobs", tags=["jobs"])
LastEventId = Annotated[
    str | None, Header(pattern=r"^[!-~]{1,128}$", description="id of the last event of an interrupted stream")
]
_EVENTS: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "One event a change",
        "content": {"text/event-stream": {"schema": {"type": "string"}}},
    }
}


_MOST = 100  # jobs looked up at a time
KINDS = {
    "measurement": MEASUREMENT.name,
    "sealed_measurement": SEALED_MEASUREMENT.name,
    "modal_model": EXTRACTION.name,
    "update": UPDATE.name,
    "diagnosis": DIAGNOSIS.name,
    "study": STUDY.name,
}
KindOfJob = Annotated[
    Literal["measurement", "sealed_measurement", "modal_model", "update", "diagnosis", "study"] | None,
    Query(description="what the jobs make; left out: anything"),
]
State = Annotated[JobState | None, Query(description="state of the jobs; left out: any")]


JobReply: Any = reply(
    Job,
    "JobStatus",
    leave_out=("arguments", "turn"),
    result_id=(str | None, "Id of the result; null until the job has succeeded."),
    error=(dict[str, Any] | None, "Problem document of a failed job; else null."),
)


def job_reply(job: Job) -> Any:
    """Return the reply of a job."""
    result_id = job.result_id if job.state is JobState.SUCCEEDED else None
    error = None if job.error is None else problems.of_job(job.error)
    return JobReply.model_validate(vars(job) | {"result_id": result_id, "error": error})


class JobPage(Reply):
    """Page of a list of jobs."""

    items: list[JobReply]
    """Jobs, newest first."""
    next: str | None
    """Value of `after` for the next page; null at the end."""


class CancelledJobs(Reply):
    """Jobs that were asked to stop."""

    cancelled: list[str]
    """Ids of the jobs."""


@router.get("", response_model=JobPage, summary="List jobs")
def list_jobs(
    jobs: JobsDep,
    viewer: ViewerDep,
    owner: OwnerWanted = None,
    state: State = None,
    kind: KindOfJob = None,
    limit: Limit = 100,
    after: After = None,
) -> JobPage:
    """Return one's own jobs, or those of another owner, page by page, newest first."""
    task = None if kind is None else KINDS[kind]
    of = viewer.owner if owner is None else owner
    found = jobs.find(viewer=viewer, owner=of, state=state, task=task, limit=limit, cursor=after)
    return JobPage(
        items=[job_reply(job) for job in found], next=found[-1].id if len(found) == limit else None
    )


@router.delete("", response_model=CancelledJobs, summary="Cancel all jobs")
def cancel_all_jobs(jobs: JobsDep, viewer: ViewerDep, kind: KindOfJob = None) -> CancelledJobs:
    """Return the ids of all of one's own waiting and running jobs after asking them to stop."""
    task, cancelled = None if kind is None else KINDS[kind], list[str]()
    for state in (JobState.QUEUED, JobState.RUNNING):
        # What is cancelled is not found again.
        while active := jobs.find(
            viewer=viewer, owner=viewer.owner, state=state, task=task, limit=_MOST, cursor=None
        ):
            ended = [jobs.cancel(job.id, viewer=viewer) for job in active]
            cancelled += [job.id for job in ended if job.state is JobState.CANCELLED]
    return CancelledJobs(cancelled=cancelled)


@router.get("/{id}", response_model=JobReply, summary="Get a job")
def get_job(id: IdPath, jobs: JobsDep, viewer: ViewerDep) -> Any:
    """Return the state and the progress of a job."""
    return job_reply(jobs.get(id, viewer=viewer))


@router.delete("/{id}", status_code=status.HTTP_200_OK, response_model=JobReply, summary="Cancel a job")
def cancel_job(id: IdPath, jobs: JobsDep, viewer: ViewerDep) -> Any:
    """Return a job after asking it to stop; a job that has ended stays as it is."""
    return job_reply(jobs.cancel(id, viewer=viewer))


@router.get("/{id}/events", response_class=StreamingResponse, responses=_EVENTS, summary="Follow a job")
async def stream_job(
    id: IdPath, jobs: JobsDep, viewer: ViewerDep, verify: VerifyDep, last_event_id: LastEventId = None
) -> StreamingResponse:
    """Return a stream of server-sent events, one a change, each with the job as JSON.

    A stream that goes on after `Last-Event-ID` does not repeat that event. It ends soon after its key has
    been revoked, or its session closed.
    """
    first = await to_thread.run_sync(
        partial(jobs.get, id, viewer=viewer)
    )  # an unknown id is a 404, no stream
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    events = _events(partial(jobs.get, id, viewer=viewer), verify, first, last_event_id)
    return StreamingResponse(events, media_type="text/event-stream", headers=headers)


async def _events(look: Callable[[], Job], verify: Verify, job: Job, seen: str | None) -> AsyncIterator[str]:
    if job.state.final or seen != _event_id(job):
        yield _event(job)
    silent = unverified = 0.0
    while not job.state.final:
        # Whoever is far from the front need not look often: a class that waits would keep the service busy.
        pause = min(JOB_STREAM.polling_interval * (job.place or 1), JOB_STREAM.longest_interval)
        await sleep(pause)
        silent, unverified = silent + pause, unverified + pause
        if unverified >= JOB_STREAM.verification_interval:
            unverified = 0.0
            try:
                await verify()
            except UnauthorisedError:
                return
        previous, job = job, await to_thread.run_sync(look)
        if job != previous:
            silent = 0.0
            yield _event(job)
        elif silent >= JOB_STREAM.keep_alive:
            silent = 0.0
            yield ": still here\n\n"


def _event(job: Job) -> str:
    return f"id: {_event_id(job)}\ndata: {job_reply(job).model_dump_json()}\n\n"


def _event_id(job: Job) -> str:
    """Return a name of what an event says."""
    return sha256(job_reply(job).model_dump_json().encode()).hexdigest()[:16]
