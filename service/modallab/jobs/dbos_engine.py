"""What the jobs need of DBOS, beside the workflows themselves in `jobs.durable`."""

import json
import logging
import threading
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import sqlalchemy as sa
from dbos import DBOS, DBOSClient, Serializer
from dbos import _queue as dbos_queue
from dbos._dbos import _get_dbos_instance

from modallab.jobs.runner import Job, Lane
from modallab.jobs.settings import JOB
from modallab.jobs.wake import Bell, Listener, Notifier

NAME = "modallab"
QUEUES = {Lane.LONG: "jobs", Lane.SHORT: "short"}
# Of their own: a job keeps its place in the queue while others make its shares.
SHARES = "shares"
# Jobs go on only under the version they were queued under. It names the shape of the workflow
# below, not of modallab: an upgrade must not strand the jobs that wait.
VERSION = "1"
_ERROR = "$error"
UNFINISHED = ("PENDING", "ENQUEUED", "DELAYED")


class RecordedError(Exception):
    """An error of a workflow or step, as the engine recorded it."""


class JsonSerializer(Serializer):
    """JSON instead of the default pickle: readable, and harmless if the database is not."""

    def serialize(self, data: Any) -> str:
        """Return values, or an error, as text."""
        return json.dumps({_ERROR: repr(data)} if isinstance(data, BaseException) else data)

    def deserialize(self, serialized_data: str) -> Any:
        """Return the values of a text, or the error that it tells of."""
        data = json.loads(serialized_data)
        return RecordedError(data[_ERROR]) if isinstance(data, dict) and _ERROR in data else data

    def name(self) -> str:
        """Return the name that the database keeps of the format."""
        return "json"


class DbosEngine:
    """What the reconciler asks of DBOS, see `jobs.reconciler.Engine`."""

    def __init__(self, client: DBOSClient, notifier: Notifier) -> None:
        self._client, self._notifier = client, notifier

    def states(self, job_ids: Sequence[str]) -> dict[str, bool]:
        """Return whether each job is still to be done, of those that DBOS knows."""
        found = self._client.list_workflows(workflow_ids=list(job_ids), load_input=False, load_output=False)
        return {workflow.workflow_id: workflow.status in UNFINISHED for workflow in found}

    def unfinished(self) -> set[str]:
        """Return the ids of all jobs that DBOS has still to do."""
        found = self._client.list_workflows(
            name="job", status=list(UNFINISHED), load_input=False, load_output=False
        )
        return {workflow.workflow_id for workflow in found}

    def owners(self) -> set[str]:
        """Return the names of the executors that jobs run on."""
        pending = self._client.list_workflows(status="PENDING", load_input=False, load_output=False)
        return {workflow.executor_id for workflow in pending if workflow.executor_id}

    def enqueue(self, job: Job) -> None:
        """Queue a job that DBOS does not know: it sorts by priority, which is from 1 on, and by age."""
        self._client.enqueue(
            {
                "workflow_name": "job",
                "queue_name": QUEUES[job.lane],
                "workflow_id": job.id,
                "app_version": VERSION,
                "priority": job.turn + 1,
            },
            job.id,
        )
        self._notifier.ring()

    def restart(self, job: Job) -> None:
        """Queue a job anew that DBOS has ended."""
        self._client.rewind_workflow(job.id, application_version=VERSION, queue_name=QUEUES[job.lane])
        self._notifier.ring()

    def stop(self, job_id: str) -> None:
        """Stop a job that is not wanted any more."""
        self._client.cancel_workflow(job_id, cancel_children=True)

    def forget(self, job_ids: Sequence[str]) -> None:
        """Remove what DBOS knows of jobs that have ended, and of their shares."""
        self._client.delete_workflows(list(job_ids), delete_children=True)

    def recover(self, executor_ids: Sequence[str]) -> None:
        """Queue anew what ran on lost executors."""
        for workflow_id in self._taken_by(executor_ids):
            self._requeue(workflow_id, executor_ids)
        self._notifier.ring()

    def abandoned(self, executor_id: str) -> set[str]:
        """Return the ids of what this process, under this name, has taken and does not work on."""
        taken = self._taken_by([executor_id])
        return taken - set(_get_dbos_instance()._active_workflows_set.activeList())

    def requeue(self, workflow_id: str, executor_id: str) -> None:
        """Queue anew what an executor has taken."""
        self._requeue(workflow_id, [executor_id])
        self._notifier.ring()

    def _taken_by(self, executor_ids: Sequence[str]) -> set[str]:
        pending = self._client.list_workflows(
            status="PENDING", executor_id=list(executor_ids), load_input=False, load_output=False
        )
        return {workflow.workflow_id for workflow in pending}

    def _requeue(self, workflow_id: str, executor_ids: Sequence[str]) -> None:
        """Queue anew a job or a share while it is still that executor's: two at once disturb nothing."""
        self._client._sys_db.reenqueue_for_recovery(workflow_id, list(executor_ids), QUEUES[Lane.LONG])


def connected(engine: sa.Engine, schema: str) -> DBOSClient:
    """Return a client of DBOS's database; it raises at once where that is away, and does not wait."""
    return DBOSClient(
        system_database_engine=engine,
        dbos_system_schema=schema,
        serializer=JsonSerializer(),
        application_name=NAME,
        retry_connection_errors=False,
    )


async def launch(
    engine: sa.Engine, schema: str, executor_id: str, bell: Bell, places: Mapping[str, int]
) -> None:
    """Start DBOS in this process.

    Parameters
    ----------
    bell
        Rings when a job may wait.
    places
        Number of jobs of each queue that this process works on at a time.
    """
    DBOS(
        config={
            "name": NAME,
            "system_database_engine": engine,
            "dbos_system_schema": schema,
            "application_version": VERSION,
            "executor_id": executor_id,
            "serializer": JsonSerializer(),
            "log_level": "WARNING",
            "run_migrations": engine.dialect.name == "sqlite",
        }
    )
    _prepare(bell)
    # In the thread of the server's event loop, which DBOS then uses: `to_process` ties its worker
    # processes to the loop's root task, and a loop of DBOS's own has none that lasts.
    DBOS.launch()
    for name, n in places.items():
        await DBOS.register_queue_async(
            name,
            worker_concurrency=n,
            polling_interval_sec=JOB.polling_interval,
            on_conflict="always_update",
        )


class Quiet(logging.Filter):
    """Drops what DBOS says of jobs that were stopped: the book has it, and it is no error."""

    _IGNORED_MESSAGES = (
        "in asynchronous workflow",
        "no longer owned",
        "task cancelled for workflow",
        "cancelled during execution",
    )

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether a message is logged."""
        message = record.getMessage()
        return not any(words in message for words in self._IGNORED_MESSAGES)


def _prepare(bell: Bell) -> None:
    """Have DBOS log as all others do, without what is no error, and look for jobs when a bell rings."""
    engine_log = logging.getLogger("dbos")
    engine_log.handlers.clear()
    engine_log.propagate = True
    if not any(isinstance(known, Quiet) for known in engine_log.filters):
        engine_log.addFilter(Quiet())
    look = dbos_queue.queue_worker_thread
    if not isinstance(look, partial):
        dbos_queue.queue_worker_thread = partial(_look_when_called, look, bell)


def _look_when_called(
    look: Callable[..., None], bell: Bell, stop: threading.Event, dbos: DBOS, queue: Any
) -> None:
    look(Listener(stop, bell), dbos, queue)
