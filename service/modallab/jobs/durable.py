"""Jobs that outlive any process: with `jobs.dbos_engine`, the only file that knows DBOS.

The book (`jobs.book`) holds what a job is and how far it is; DBOS holds that it must still be done.
What a crash leaves between the two, and what a lost worker leaves, a reconciler mends (`jobs.reconciler`).
"""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Self

import anyio
import sqlalchemy as sa
import structlog
from anyio import BrokenWorkerProcess, to_thread
from dbos import DBOS, DBOSClient
from dbos import error as dbos_error

from modallab.jobs.book import JobBook
from modallab.jobs.dbos_engine import QUEUES, SHARES, DbosEngine, connected, launch
from modallab.jobs.executors import Executor, ExecutorBook, Watch
from modallab.jobs.outages import is_outage, patiently
from modallab.jobs.processes import WorkerProcesses
from modallab.jobs.reconciler import Reconciler
from modallab.jobs.retention import Retention
from modallab.jobs.runner import Job, JobState, Lane, RequestKey, time_limit_error
from modallab.jobs.settings import JOB
from modallab.jobs.wake import Bell, Notifier
from modallab.jobs.work import INTERNAL, count_shares, describe, end_due, log_end, perform, perform_share
from modallab.store.engine import make_engine
from modallab.store.place import StorePlace, engine_of
from modallab.store.viewer import Viewer

_log = structlog.get_logger()
Result = Any  # plain values of a share


@dataclass(frozen=True)
class _Site:
    """Resources of the process in which the workflow runs."""

    place: StorePlace
    book: JobBook
    processes: WorkerProcesses
    notifier: Notifier


_BELL = Bell()
_site: _Site | None = None  # DBOS is one a process, and its workflows are module-level functions


def _broke(error: BaseException) -> bool:
    return isinstance(error, BrokenWorkerProcess)


_step = partial(
    DBOS.step,
    preemptible=True,
    retries_allowed=True,
    max_attempts=JOB.max_attempts,
    interval_seconds=0.1,
    backoff_rate=JOB.attempt_backoff,
    should_retry=_broke,
)


@_step(name="perform")
async def _perform(job_id: str, shares: Sequence[Result] | None) -> None:
    assert _site is not None
    lane = (await to_thread.run_sync(patiently, _site.book.get, job_id)).lane
    try:
        with anyio.fail_after(JOB.time_limit):
            fault = await _site.processes.run(perform, _site.place, job_id, shares, lane=lane)
    except TimeoutError:
        await to_thread.run_sync(patiently, _site.book.fail, job_id, describe(time_limit_error()))
        return
    if fault is not None:
        _log.error("job failed", job=job_id, fault=fault)


@_step(name="perform_share")
async def _perform_share(job_id: str, index: int) -> Result:
    assert _site is not None
    try:
        with anyio.fail_after(JOB.time_limit):
            result, fault = await _site.processes.run(
                perform_share, _site.place, job_id, index, lane=Lane.LONG
            )
    except TimeoutError:
        _log.error("share of a job took too long", job=job_id, share=index)
        return None
    if fault is not None:
        _log.error("share of a job failed", job=job_id, share=index, fault=fault)
    return result


# A restart of the service is no attempt of the job.
@DBOS.workflow(name="share", max_recovery_attempts=None)
async def _share(job_id: str, index: int) -> Result:
    try:
        return await _perform_share(job_id, index)
    except dbos_error.DBOSMaxStepRetriesExceeded:
        _log.error("the worker process died under a share again and again", job=job_id, share=index)
        return None
    finally:
        _BELL.ring()  # a place is free


async def _results_of_shares(job_id: str) -> Sequence[Result] | None:
    """Return the results of a job's shares, in order; None if it has no shares."""
    assert _site is not None
    book = _site.book
    n = count_shares(await to_thread.run_sync(patiently, book.get, job_id))
    if n == 0:
        return None
    await to_thread.run_sync(patiently, book.progress, job_id, 0.0, f"0 of {n} runs")
    workflows = [await DBOS.enqueue_workflow_async(SHARES, _share, job_id, index) for index in range(n)]
    await to_thread.run_sync(_site.notifier.ring)
    results: list[Result] = []
    for share in workflows:
        results.append(await share.get_result(polling_interval_sec=JOB.polling_interval))
        done = f"{len(results)} of {n} runs"
        await to_thread.run_sync(patiently, book.progress, job_id, len(results) / n, done)
    return results


@DBOS.workflow(name="job", max_recovery_attempts=None)
async def _job(job_id: str) -> None:
    assert _site is not None
    try:
        await _perform(job_id, await _results_of_shares(job_id))
    except dbos_error.DBOSMaxStepRetriesExceeded:
        _log.error("the worker process died under a job again and again", job=job_id)
        await to_thread.run_sync(patiently, _site.book.fail, job_id, INTERNAL)
    finally:
        _BELL.ring()
    log_end(await to_thread.run_sync(patiently, _site.book.get, job_id))


@dataclass(frozen=True)
class JobPlace:
    """Database of DBOS: a separate SQLite file, or a separate schema."""

    url: str
    schema: str

    def prepare(self) -> None:
        """Create DBOS's tables in PostgreSQL; in SQLite the first start does."""
        if not self.url.startswith("sqlite"):
            url = sa.make_url(self.url).set(drivername="postgresql+psycopg")
            DBOS.migrate(url.render_as_string(hide_password=False), schema=self.schema)


class DurableRunner:
    """Submits jobs, and runs them as an executor unless it only submits.

    Parameters
    ----------
    executor_id
        Name of this process among those that run jobs; None: made from host and process.
    runs
        Whether it runs jobs.
    retention
        What is removed when it is old; None: nothing is.
    """

    def __init__(
        self,
        book: JobBook,
        place: StorePlace,
        jobs: JobPlace,
        *,
        executor_id: str | None = None,
        runs: bool = True,
        retention: Retention | None = None,
    ) -> None:
        self._book, self._place, self._jobs, self._retention = book, place, jobs, retention
        self._executor = Executor.here(executor_id) if runs else None
        self._executors, self._watch = ExecutorBook(engine_of(place)), Watch()
        self._engine = make_engine(jobs.url, schema=jobs.schema)
        self._notifier = Notifier(self._engine, jobs.schema, _BELL)
        self._client: DBOSClient | None = None
        self._reconciler: Reconciler | None = None

    async def __aenter__(self) -> Self:
        """Start, and take up what was left undone.

        Raises
        ------
        ExecutorTakenError
            If another process runs jobs under the same name.
        """
        if self._executor is not None:
            await to_thread.run_sync(self._executors.enter, self._executor)
            self._notifier.listen()
            await self._launch(self._executor.id)
        self._client = await to_thread.run_sync(connected, self._engine, self._jobs.schema)
        if self._executor is not None:
            self._reconciler = Reconciler(
                self._executor,
                self._executors,
                self._book,
                DbosEngine(self._client, self._notifier),
                self._retention,
                end=partial(end_due, self._place),
            )
            await to_thread.run_sync(self._reconciler.start)
        return self

    async def _launch(self, executor_id: str) -> None:
        global _site
        # One is kept for short jobs, so that there are two even where there is one core.
        most = max(2, (os.cpu_count() or 1) - 1)
        _site = _Site(self._place, self._book, WorkerProcesses(most, most_long=most - 1), self._notifier)
        # One more share than can be worked on: it is there when a process is free, without another poll.
        places = {QUEUES[Lane.LONG]: most - 1, QUEUES[Lane.SHORT]: most, SHARES: most}
        await launch(self._engine, self._jobs.schema, executor_id, _BELL, places)

    async def __aexit__(self, *exception: object) -> None:
        """Stop; jobs under way are queued anew, for whichever executor is free."""
        if self._reconciler is not None:
            await to_thread.run_sync(self._reconciler.stop)
        if self._executor is not None:
            await to_thread.run_sync(DBOS.destroy)
            if _site is not None:
                await _site.processes.leave()
            await to_thread.run_sync(self._hand_back, self._executor)
            await to_thread.run_sync(self._notifier.end)
        if self._client is not None:
            await to_thread.run_sync(self._client.destroy)
        self._engine.dispose()

    def _hand_back(self, executor: Executor) -> None:
        """Queue anew what this process was working on, and leave the executors."""
        try:
            if self._client is not None:
                DbosEngine(self._client, self._notifier).recover([executor.id])
            self._executors.remove(executor)
        except Exception as error:  # the others will take this process for lost
            if not is_outage(error):
                raise
            _log.warning("jobs could not be handed back", error=str(error).splitlines()[0])

    def submit(
        self,
        task: str,
        arguments: Mapping[str, Any],
        *,
        owner: str,
        lane: Lane = Lane.LONG,
        request: RequestKey | None = None,
    ) -> Job:
        """Queue a task and return its job."""
        job = self._book.open(task, arguments, owner=owner, lane=lane, request=request)
        # An id that is queued already is queued once.
        self._inform_engine(lambda engine: engine.enqueue(job))
        _log.info("job queued", job=job.id, task=task)
        return job

    def get(self, job_id: str, *, viewer: Viewer) -> Job:
        """Return a job, if it is there for the viewer."""
        return self._book.get(job_id, viewer=viewer)

    def is_served(self) -> bool:
        """Return whether a process lives that runs jobs: this one, or another that shows it."""
        if self._executor is not None:
            return True
        executors = self._executors.all()
        return len(self._watch.lost(executors)) < len(executors)

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
        """Stop a job and return it; a job that has ended stays as it is."""
        job = self._book.get(job_id, viewer=viewer)
        if self._book.cancel(job.id):
            self._inform_engine(lambda engine: engine.stop(job.id))
        return self._book.get(job.id)

    def _inform_engine(self, tell: Callable[[DbosEngine], None]) -> None:
        """Tell the engine what the book says; where its database is just away a reconciler does later."""
        assert self._client is not None
        try:
            tell(DbosEngine(self._client, self._notifier))
        except Exception as error:
            if not is_outage(error):
                raise
            _log.warning("the engine of jobs hears of a job later", error=str(error).splitlines()[0])
