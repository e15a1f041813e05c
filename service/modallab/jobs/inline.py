"""Jobs at once, in the thread that submits them: for tests and small scripts."""

import time
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any, Self

from modallab.jobs.book import JobBook
from modallab.jobs.runner import Job, JobState, Lane, RequestKey
from modallab.jobs.work import end_due, perform
from modallab.store.place import StorePlace
from modallab.store.viewer import Viewer


class InlineRunner:
    """Runs every job before `submit` returns."""

    def __init__(self, book: JobBook, place: StorePlace) -> None:
        self._book, self._place = book, place

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *exception: object) -> None:
        pass

    def submit(
        self,
        task: str,
        arguments: Mapping[str, Any],
        *,
        owner: str,
        lane: Lane = Lane.LONG,
        request: RequestKey | None = None,
    ) -> Job:
        """Do a task and return its job."""
        job = self._book.open(task, arguments, owner=owner, lane=lane, request=request)
        if job.state.final:
            return job  # the same request once more
        fault = perform(self._place, job.id)
        if fault is not None:
            raise RuntimeError(f"task {task} failed:\n{fault}")
        for due in self._book.due():
            if due.id == job.id:
                time.sleep(max(0.0, due.rest(datetime.now(UTC))))
                end_due(self._place, due)
        return self._book.get(job.id)

    def get(self, job_id: str, *, viewer: Viewer) -> Job:
        """Return a job, if it is there for the viewer."""
        return self._book.get(job_id, viewer=viewer)

    def is_served(self) -> bool:
        """Return True: this process runs its jobs."""
        return True

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
        return self._book.find(viewer=viewer, owner=owner, state=state, task=task, limit=limit, cursor=cursor)

    def cancel(self, job_id: str, *, viewer: Viewer) -> Job:
        """Return the job: what this runner did has ended before anyone could cancel it."""
        self._book.cancel(self._book.get(job_id, viewer=viewer).id)
        return self._book.get(job_id)
