"""Do one job: what a worker process runs."""

import os
import time
import traceback
from collections.abc import Mapping, Sequence
from datetime import datetime
from itertools import pairwise
from typing import Any, cast

import structlog

from modallab.core.errors import CancelledError, ModalLabError, sentence
from modallab.jobs.book import JobBook
from modallab.jobs.destination import Destination
from modallab.jobs.outages import is_outage, patiently
from modallab.jobs.postponed import DueJob
from modallab.jobs.runner import Job
from modallab.jobs.settings import JOB
from modallab.jobs.tasks import ENDINGS_BY_TASK, SHARES_BY_TASK, TASKS
from modallab.store.base import Store
from modallab.store.place import StorePlace, engine_of, open_store

Json = Any
_log = structlog.get_logger()


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
        if now - self._written < JOB.progress_interval:
            return
        self._written = now
        is_requested = self._entered(fraction, message)
        # An orphan would work for nobody: whoever restarts the service does the job anew.
        if not is_requested or os.getppid() != self._parent:
            raise CancelledError("the job is not wanted any more")

    def _entered(self, fraction: float, message: str) -> bool:
        try:
            return self._written_down(fraction, message)
        except Exception as error:
            if is_outage(error):  # the work goes on, and its owner hears of it later
                return True
            raise

    def _written_down(self, fraction: float, message: str) -> bool:
        return self._book.progress(self._job_id, min(max(fraction, 0.0), 1.0), message)


class ShareReporter(Reporter):
    """Progress callback of a share: it stops with its job; the job's own worker reports progress."""

    def _written_down(self, fraction: float, message: str) -> bool:
        return self._book.is_active(self._job_id)


def count_shares(job: Job) -> int:
    """Return the number of independent shares of a job; 0 for most jobs."""
    return SHARES_BY_TASK[job.task].count(**job.arguments) if job.task in SHARES_BY_TASK else 0


def perform_share(place: StorePlace, job_id: str, index: int) -> tuple[Json, str | None]:
    """Return the result of a share of a job, None if there is none, and the traceback of an internal error.

    A module-level function of plain values, as `perform`.
    """
    return patiently(_performed_share, place, job_id, index)


def _performed_share(place: StorePlace, job_id: str, index: int) -> tuple[Json, str | None]:
    book = JobBook(engine_of(place), queue_length=0)
    if not book.start(job_id):
        return None, None
    job = book.get(job_id)
    try:
        report = ShareReporter(book, job_id)
        return SHARES_BY_TASK[job.task].run_share(
            cast(Store, open_store(place)), report, index, **job.arguments
        ), None
    except ModalLabError:
        return None, None  # not wanted; or what the rest of the job will say too
    except Exception as error:
        if is_outage(error):
            raise
        return None, traceback.format_exc()


def perform(place: StorePlace, job_id: str, shares: Sequence[Json] | None = None) -> str | None:
    """Run a job, record its outcome, and return the traceback of an internal error, if any.

    A module-level function of plain values, so that it can be sent to another process; it may run
    twice for the same job, and then stores its result once.

    Parameters
    ----------
    shares
        Of a task that has any, what workers made of them.

    Raises
    ------
    DBAPIError
        If the database stays away; until then the work is done anew.
    """
    return patiently(_performed, place, job_id, shares)


def _performed(place: StorePlace, job_id: str, shares: Sequence[Json] | None) -> str | None:
    book = JobBook(engine_of(place), queue_length=0)
    if not book.start(job_id):
        return None
    job = book.get(job_id)
    into = Destination(job.owner, job.result_id)
    keywords = {} if shares is None else {"shares": shares}
    try:
        later = TASKS[job.task](open_store(place), Reporter(book, job_id), into, **job.arguments, **keywords)
    except CancelledError:
        return None
    except ModalLabError as error:
        patiently(book.fail, job_id, describe(error))
        return None
    except Exception as error:
        if is_outage(error):
            raise
        patiently(book.fail, job_id, INTERNAL)
        return traceback.format_exc()
    if later is None:
        patiently(book.succeed, job_id)
    else:
        problem = None if later.error is None else describe(later.error)
        patiently(book.postpone, job_id, later, problem)
    return None


def end_due(place: StorePlace, due: DueJob) -> None:
    """End a job whose time has come: its owner has the result, or nobody has if the job was cancelled."""
    book, store = JobBook(engine_of(place), queue_length=0), cast(Store, open_store(place))
    job = book.get(due.id)
    into, ending = Destination(job.owner, job.result_id), ENDINGS_BY_TASK[job.task]
    if due.active and due.good:
        ending.publish(store, into, due.due, **job.arguments)
    else:
        ending.withdraw(store, into)
    if book.end_due(due.id):
        log_end(book.get(due.id))


def log_end(job: Job) -> None:
    """Log a job that has ended, with the seconds that it waited and ran; no other."""
    if not job.state.final:
        return
    moments = [
        None if m is None else datetime.fromisoformat(m) for m in (job.created, job.started, job.ended)
    ]
    waited, ran = (
        None if begin is None or end is None else round((end - begin).total_seconds(), 3)
        for begin, end in pairwise(moments)
    )
    _log.info("job ended", job=job.id, task=job.task, state=job.state.value, waited=waited, ran=ran)


INTERNAL: Mapping[str, Any] = {
    "code": "internal",
    "title": "InternalError",
    "detail": "the service failed at this job; its log says why",
    "context": {},
}


def describe(error: ModalLabError) -> dict[str, Any]:
    """Return an error as the values of a problem document."""
    return {
        "code": error.code,
        "title": type(error).__name__,
        "detail": sentence(error),
        "context": error.context,
    }
