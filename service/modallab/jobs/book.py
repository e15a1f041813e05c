"""The book of jobs: one row each, written by whoever works on it."""

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

import sqlalchemy as sa

from modallab.core.errors import NotFoundError
from modallab.jobs.runner import Job, JobState, QueueFullError
from modallab.store.sql import new_id
from modallab.store.tables import JOBS

_ACTIVE = JOBS.c.state.in_([JobState.QUEUED.value, JobState.RUNNING.value])


class JobBook:
    """Jobs in the store's database. Rows that have ended never change again."""

    def __init__(self, engine: sa.Engine, *, queue_length: int) -> None:
        self._engine, self._queue_length = engine, queue_length

    def open(self, task: str, arguments: Mapping[str, Any], *, owner: str) -> Job:
        """Enter a job and return it; `QueueFullError` if too many wait."""
        row: dict[str, Any] = {
            "id": new_id(),
            "owner": owner,
            "task": task,
            "arguments": dict(arguments),
            "created": datetime.now(UTC).isoformat(timespec="microseconds"),
            "state": JobState.QUEUED.value,
            "fraction": 0.0,
            "message": "",
            "result_id": new_id(),
            "restarts": 0,
        }
        queue_length = sa.select(sa.func.count()).where(JOBS.c.state == JobState.QUEUED.value)
        with self._engine.begin() as connection:
            if connection.execute(queue_length).scalar_one() >= self._queue_length:
                raise QueueFullError("as many jobs wait as may", allowed=self._queue_length)
            connection.execute(JOBS.insert().values(**row))
        return _job(row)

    def get(self, job_id: str, *, owner: str | None = None) -> Job:
        """Return a job, of an owner if one is named."""
        query = sa.select(JOBS).where(JOBS.c.id == job_id)
        if owner is not None:
            query = query.where(JOBS.c.owner == owner)
        with self._engine.begin() as connection:
            row = connection.execute(query).first()
        if row is None:
            raise NotFoundError(f"there is no job {job_id!r}", field="job_id", value=job_id)
        return _job(row._asdict())

    def active(self) -> list[str]:
        """Return the ids of all jobs that have not ended, oldest first."""
        with self._engine.begin() as connection:
            return list(
                connection.execute(sa.select(JOBS.c.id).where(_ACTIVE).order_by(JOBS.c.created)).scalars()
            )

    def is_active(self, job_id: str) -> bool:
        """Tell whether a job has not ended."""
        query = sa.select(JOBS.c.id).where(JOBS.c.id == job_id, _ACTIVE)
        with self._engine.begin() as connection:
            return connection.execute(query).first() is not None

    def start(self, job_id: str) -> bool:
        """Mark a job as running and tell whether it still has to be done."""
        return self._change(job_id, state=JobState.RUNNING.value)

    def progress(self, job_id: str, fraction: float, message: str) -> bool:
        """Write how far a job is and tell whether it is still wanted."""
        return self._change(job_id, fraction=fraction, message=message)

    def count_restart(self, job_id: str) -> int:
        """Count a restart of a job, and return how many there were."""
        update = JOBS.update().where(JOBS.c.id == job_id).values(restarts=JOBS.c.restarts + 1)
        with self._engine.begin() as connection:
            connection.execute(update)
            return int(connection.execute(sa.select(JOBS.c.restarts).where(JOBS.c.id == job_id)).scalar_one())

    def succeed(self, job_id: str) -> bool:
        """End a job whose result is stored."""
        return self._change(job_id, state=JobState.SUCCEEDED.value, fraction=1.0)

    def fail(self, job_id: str, error: Mapping[str, Any]) -> bool:
        """End a job with the error that stopped it."""
        return self._change(job_id, state=JobState.FAILED.value, error=dict(error))

    def cancel(self, job_id: str) -> bool:
        """End a job because its owner asked for it."""
        return self._change(job_id, state=JobState.CANCELLED.value)

    def _change(self, job_id: str, **values: Any) -> bool:
        update = JOBS.update().where(JOBS.c.id == job_id, _ACTIVE).values(**values)
        with self._engine.begin() as connection:
            return connection.execute(update).rowcount == 1


def _job(row: Mapping[str, Any]) -> Job:
    fields = {name: value for name, value in row.items() if name != "restarts"}
    return Job(**dict(fields, state=JobState(row["state"])))
