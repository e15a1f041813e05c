"""Keeps book and engine of jobs in agreement, and takes over what a lost executor left.

Every executor does so every few seconds: whatever fails, at whatever moment, each job ends without
anybody's help.
"""

import math
import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from typing import Protocol

import psutil
import structlog

from modallab.jobs.book import JobBook
from modallab.jobs.executors import Executor, ExecutorBook, Watch
from modallab.jobs.outages import is_outage
from modallab.jobs.postponed import DueJob, Timer
from modallab.jobs.retention import Retention
from modallab.jobs.runner import Job
from modallab.jobs.settings import JOB
from modallab.jobs.work import INTERNAL

_log = structlog.get_logger()


class Engine(Protocol):
    """What a reconciler asks of the engine of jobs."""

    def states(self, job_ids: Sequence[str]) -> dict[str, bool]:
        """Return whether each job is still to be done, of those that the engine knows."""
        ...

    def unfinished(self) -> set[str]:
        """Return the ids of all jobs that the engine has still to do."""
        ...

    def owners(self) -> set[str]:
        """Return the names of the executors that jobs run on."""
        ...

    def enqueue(self, job: Job) -> None:
        """Queue a job that the engine does not know."""
        ...

    def restart(self, job: Job) -> None:
        """Queue a job anew that the engine has ended."""
        ...

    def stop(self, job_id: str) -> None:
        """Stop a job that is not wanted any more."""
        ...

    def forget(self, job_ids: Sequence[str]) -> None:
        """Remove what is known of jobs that have ended."""
        ...

    def recover(self, executor_ids: Sequence[str]) -> None:
        """Queue anew what ran on lost executors."""
        ...

    def abandoned(self, executor_id: str) -> set[str]:
        """Return the ids of what this process, under this name, has taken and does not work on."""
        ...

    def requeue(self, workflow_id: str, executor_id: str) -> None:
        """Queue anew what an executor has taken."""
        ...


def end_stopped_children() -> None:
    """Kill the worker processes that something has stopped: their work is then done in another."""
    for child in psutil.Process().children():
        with suppress(psutil.NoSuchProcess):
            if child.status() == psutil.STATUS_STOPPED:
                _log.error("a worker process stands still and is ended", pid=child.pid)
                child.kill()


class Reconciler:
    """A thread that beats for an executor and mends what others left."""

    def __init__(
        self,
        executor: Executor,
        executors: ExecutorBook,
        book: JobBook,
        engine: Engine,
        retention: Retention | None = None,
        *,
        end: Callable[[DueJob], None] | None = None,
    ) -> None:
        self._executor, self._executors, self._book, self._engine = executor, executors, book, engine
        self._end, self._timer = end, Timer()
        self._retention, self._swept = retention, -math.inf
        self._watch = Watch()
        self._suspects: dict[str, set[str]] = {}
        self._idle_beats = 0  # since a job was active
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="reconciler", daemon=True)

    def start(self) -> None:
        """Mend at once, and then every few seconds."""
        self.mend()
        self._thread.start()

    def stop(self) -> None:
        """Stop."""
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._ended.wait(JOB.beat_interval):
            try:
                if not self._executors.beat(self._executor):
                    _log.error("another process took this executor's name", executor=self._executor.id)
                    os.kill(os.getpid(), signal.SIGTERM)
                    return
                end_stopped_children()
                self._sweep()
                self._idle_beats += 1
                if self._idle_beats % JOB.idle_beats == 0:
                    self.mend()
            except Exception as error:  # the database is away, say: the next beat tries again
                _log.warning("jobs could not be reconciled", error=str(error).splitlines()[0])

    def _sweep(self) -> None:
        """Remove what is kept no longer, seldom."""
        if self._retention is not None and time.monotonic() - self._swept > JOB.sweep_interval:
            self._swept = time.monotonic()
            self._retention.sweep(self._engine)

    def mend(self) -> None:
        """Take over what lost executors left, and make book and engine agree."""
        self._take_over()
        active = set(self._book.active())
        if self._end_due() or active or any(self._suspects.values()):
            self._idle_beats = -1
        states = self._engine.states(sorted(active)) if active else {}
        unknown = {job_id for job_id in active if job_id not in states}
        ended = {job_id for job_id in active if states.get(job_id) is False}
        unwanted = self._engine.unfinished() - active
        self._settle("unknown", unknown, self._enqueue, active=True)
        self._settle("ended", ended, self._restart, active=True)
        self._settle("unwanted", unwanted, self._engine.stop, active=False)
        self._settle("abandoned", self._engine.abandoned(self._executor.id), self._requeue, active=None)

    def _end_due(self) -> bool:
        """End the jobs whose time has come, and return whether others are left."""
        jobs = self._book.due() if self._end is not None else []
        over = self._timer.over(jobs, datetime.now(UTC))
        for job in over:
            self._end_one(job)
        return len(over) < len(jobs)

    def _end_one(self, job: DueJob) -> None:
        assert self._end is not None
        try:
            self._end(job)
        except Exception as error:
            if is_outage(error):
                raise
            _log.exception("a job could not be ended", job=job.id)
            self._book.fail(job.id, INTERNAL)

    def _take_over(self) -> None:
        # Owners first: an executor that has a job has entered before, and is then among the executors.
        owners = self._engine.owners()
        executors = self._executors.all()
        lost = self._watch.lost([e for e in executors if e.holder != self._executor.holder])
        strangers = owners - {executor.id for executor in executors} - {self._executor.id}
        gone = {executor.id for executor in lost} | strangers
        if gone:
            _log.info("jobs of lost executors are queued anew", executors=sorted(gone))
            self._engine.recover(sorted(gone))
        for executor in lost:
            self._executors.remove(executor)

    def _settle(
        self, what: str, job_ids: set[str], act: Callable[[str], None], *, active: bool | None
    ) -> None:
        """Act on jobs that were found so twice: once may be the moment between two entries.

        Parameters
        ----------
        active
            Whether the book has still to have them as active; None: either.
        """
        for job_id in job_ids & self._suspects.get(what, set()):
            if active is None or self._book.is_active(job_id) is active:
                act(job_id)
        self._suspects[what] = job_ids

    def _enqueue(self, job_id: str) -> None:
        self._engine.enqueue(self._book.get(job_id))

    def _requeue(self, workflow_id: str) -> None:
        """Queue anew what was taken and never started, as where the database went away between the two."""
        _log.info("a job that was not started is queued anew", job=workflow_id)
        self._engine.requeue(workflow_id, self._executor.id)

    def _restart(self, job_id: str) -> None:
        """Queue a job anew that the engine has ended and the book has not."""
        if self._book.count_restart(job_id) > JOB.max_restarts:
            self._book.fail(job_id, INTERNAL)
        else:
            self._engine.restart(self._book.get(job_id))
