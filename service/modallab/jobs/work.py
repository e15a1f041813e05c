"""Do one job: what a worker process runs."""

import os
import time
import traceback
from collections.abc import Mapping
from typing import Any

from modallab.core.errors import CancelledError, ModalLabError
from modallab.jobs.book import JobBook
from modallab.jobs.destination import Destination
from modallab.jobs.tasks import TASKS
from modallab.store.place import StorePlace, engine_of, open_store

_INTERVAL = 0.1  # s between two entries of progress in the book


class Reporter:
    """A progress callback that writes into the book and stops the work when it is not wanted."""

    def __init__(self, book: JobBook, job_id: str) -> None:
        self._book, self._job_id = book, job_id
        self._parent, self._written = os.getppid(), 0.0

    def __call__(self, fraction: float, message: str) -> None:
        """Write the progress, at most ten times a second.

        Raises
        ------
        CancelledError
            If the job was cancelled, or the service that started this process is gone.
        """
        now = time.monotonic()
        if now - self._written < _INTERVAL:
            return
        self._written = now
        wanted = self._book.progress(self._job_id, min(max(fraction, 0.0), 1.0), message)
        # An orphan would work for nobody: whoever restarts the service does the job anew.
        if not wanted or os.getppid() != self._parent:
            raise CancelledError("the job is not wanted any more")


def perform(place: StorePlace, job_id: str) -> str | None:
    """Do a job, enter how it ended, and return the traceback of a fault of ours, if there was one.

    A module-level function of plain values, so that it can be sent to another process; it may run
    twice for the same job, and then stores its result once.
    """
    book = JobBook(engine_of(place), queue_length=0)
    if not book.start(job_id):
        return None
    job = book.get(job_id)
    into = Destination(job.owner, job.result_id)
    try:
        TASKS[job.task](open_store(place), Reporter(book, job_id), into, **job.arguments)
    except CancelledError:
        return None
    except ModalLabError as error:
        book.fail(job_id, describe(error))
        return None
    except Exception:
        book.fail(job_id, INTERNAL)
        return traceback.format_exc()
    book.succeed(job_id)
    return None


INTERNAL: Mapping[str, Any] = {
    "code": "internal",
    "title": "InternalError",
    "detail": "the service failed at this job; its log says why",
    "context": {},
}


def describe(error: ModalLabError) -> dict[str, Any]:
    """Return an error as the plain values of a problem document."""
    return {"code": error.code, "title": type(error).__name__, "detail": str(error), "context": error.context}
