"""The book of jobs: one row each, written by whoever works on it."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

import sqlalchemy as sa

from modallab.core.errors import NotFoundError
from modallab.jobs.postponed import DueJob, Postponed
from modallab.jobs.queue import ACTIVE, check_room, next_turn, with_places
from modallab.jobs.runner import Job, JobState, KeyReusedError, Lane, RequestKey
from modallab.store.quotas import NO_QUOTAS, Quotas
from modallab.store.rows import new_id
from modallab.store.tables import JOBS
from modallab.store.viewer import EVERYONE, Viewer, manageable

_UNSHOWN = ("restarts", "request_key", "request_digest", "due")
_UNDONE = sa.and_(ACTIVE, JOBS.c.due.is_(None))


class JobBook:
    """Jobs in the store's database. Rows that have ended never change again."""

    def __init__(self, engine: sa.Engine, *, queue_length: int, quotas: Quotas = NO_QUOTAS) -> None:
        self._engine, self._queue_length, self._quotas = engine, queue_length, quotas

    def open(
        self,
        task: str,
        arguments: Mapping[str, Any],
        *,
        owner: str,
        lane: Lane = Lane.LONG,
        request: RequestKey | None = None,
    ) -> Job:
        """Enter a job and return it; the job of the same request if there was one.

        Raises
        ------
        QueueFullError, QueueQuotaError
            If too many wait, of all or of the owner and the class.
        KeyReusedError
            If another request of the owner had the key.
        """
        if request is not None and (known := self._of_request(owner, request)) is not None:
            return known
        row: dict[str, Any] = {
            "id": new_id(),
            "owner": owner,
            "task": task,
            "arguments": dict(arguments),
            "created": _now(),
            "state": JobState.QUEUED.value,
            "fraction": 0.0,
            "message": "",
            "result_id": new_id(),
            "restarts": 0,
            "request_key": None if request is None else request.key,
            "request_digest": None if request is None else request.digest,
            "lane": lane.value,
            "turn": next_turn(owner, lane),
        }
        try:
            with self._engine.begin() as connection:
                if connection.dialect.name == "postgresql":  # SQLite has one writer at a time anyway
                    connection.execute(sa.select(sa.func.pg_advisory_xact_lock(sa.func.hashtext(owner))))
                connection.execute(JOBS.insert().values(**row))
                check_room(connection, owner, self._queue_length, self._quotas)
        except sa.exc.IntegrityError:  # the same request came twice at once
            if request is None or (known := self._of_request(owner, request)) is None:
                raise
            return known
        return self.get(row["id"])

    def _of_request(self, owner: str, request: RequestKey) -> Job | None:
        query = sa.select(JOBS).where(JOBS.c.owner == owner, JOBS.c.request_key == request.key)
        with self._engine.begin() as connection:
            row = connection.execute(query).first()
        if row is None:
            return None
        if row.request_digest != request.digest:
            raise KeyReusedError(
                "this key named another request",
                field="Idempotency-Key",
                value=request.key,
                allowed="a new key for each request, the same for its repetition",
            )
        return self._with_places([_job(row._asdict())])[0]

    def get(self, job_id: str, *, viewer: Viewer = EVERYONE) -> Job:
        """Return a job, if it is there for the viewer."""
        query = sa.select(JOBS).where(JOBS.c.id == job_id, manageable(JOBS.c.owner, viewer))
        with self._engine.begin() as connection:
            row = connection.execute(query).first()
        if row is None:
            raise NotFoundError(f"there is no job {job_id!r}", field="job_id", value=job_id)
        return self._with_places([_job(row._asdict())])[0]

    def find(
        self,
        *,
        viewer: Viewer = EVERYONE,
        owner: str | None = None,
        state: JobState | None = None,
        task: str | None = None,
        limit: int = 100,
        cursor: str | None = None,
    ) -> list[Job]:
        """Return the newest jobs that exist for a viewer, those of an owner if named, before `cursor`."""
        query = sa.select(JOBS).where(manageable(JOBS.c.owner, viewer))
        if owner is not None:
            query = query.where(JOBS.c.owner == owner)
        if state is not None:
            query = query.where(JOBS.c.state == state.value)
        if task is not None:
            query = query.where(JOBS.c.task == task)
        if cursor is not None:
            last = self.get(cursor, viewer=viewer)
            age = sa.tuple_(JOBS.c.created, JOBS.c.id)
            query = query.where(age < sa.tuple_(sa.literal(last.created), sa.literal(last.id)))
        query = query.order_by(JOBS.c.created.desc(), JOBS.c.id.desc()).limit(limit)
        with self._engine.begin() as connection:
            jobs = [_job(row._asdict()) for row in connection.execute(query)]
        return self._with_places(jobs)

    def _with_places(self, jobs: list[Job]) -> list[Job]:
        with self._engine.begin() as connection:
            return with_places(connection, jobs)

    def active(self) -> list[str]:
        """Return the ids of all jobs whose work is not done, oldest first."""
        with self._engine.begin() as connection:
            return list(
                connection.execute(sa.select(JOBS.c.id).where(_UNDONE).order_by(JOBS.c.created)).scalars()
            )

    def needs(self) -> list[Mapping[str, Any]]:
        """Return the arguments of all jobs that have not ended."""
        with self._engine.begin() as connection:
            return list(connection.execute(sa.select(JOBS.c.arguments).where(ACTIVE)).scalars())

    def ended_before(self, time: str) -> list[str]:
        """Return the ids of the jobs that ended before a time, ISO 8601."""
        query = sa.select(JOBS.c.id).where(~ACTIVE, sa.func.coalesce(JOBS.c.ended, JOBS.c.created) < time)
        with self._engine.begin() as connection:
            return list(connection.execute(query).scalars())

    def remove(self, job_ids: Sequence[str]) -> None:
        """Forget jobs that have ended."""
        with self._engine.begin() as connection:
            connection.execute(JOBS.delete().where(JOBS.c.id.in_(job_ids), ~ACTIVE))

    def is_active(self, job_id: str) -> bool:
        """Tell whether a job's work is wanted and not done."""
        query = sa.select(JOBS.c.id).where(JOBS.c.id == job_id, _UNDONE)
        with self._engine.begin() as connection:
            return connection.execute(query).first() is not None

    def start(self, job_id: str) -> bool:
        """Mark a job as running and tell whether it still has to be done."""
        started = sa.func.coalesce(JOBS.c.started, _now())  # of the first attempt
        update = JOBS.update().where(JOBS.c.id == job_id, _UNDONE)
        with self._engine.begin() as connection:
            changed = connection.execute(update.values(state=JobState.RUNNING.value, started=started))
            return changed.rowcount == 1

    def progress(self, job_id: str, fraction: float, message: str) -> bool:
        """Write how far a job is and tell whether it is still wanted."""
        return self._change(job_id, fraction=fraction, message=message)

    def count_restart(self, job_id: str) -> int:
        """Count a restart of a job, and return how many there were."""
        update = JOBS.update().where(JOBS.c.id == job_id).values(restarts=JOBS.c.restarts + 1)
        with self._engine.begin() as connection:
            connection.execute(update)
            return int(connection.execute(sa.select(JOBS.c.restarts).where(JOBS.c.id == job_id)).scalar_one())

    def postpone(self, job_id: str, later: Postponed, error: Mapping[str, Any] | None) -> None:
        """Enter when and how a job will end whose work is done."""
        query = sa.select(JOBS.c.started).where(JOBS.c.id == job_id)
        with self._engine.begin() as connection:
            started = connection.execute(query).scalar_one()
        due = later.due(started, datetime.now(UTC)).isoformat(timespec="microseconds")
        self._change(job_id, due=due, error=None if error is None else dict(error))

    def due(self) -> list[DueJob]:
        """Return the jobs that only their end is left of."""
        columns = JOBS.c.id, JOBS.c.started, JOBS.c.due, ACTIVE, JOBS.c.error.is_(None)
        with self._engine.begin() as connection:
            rows = connection.execute(sa.select(*columns).where(JOBS.c.due.is_not(None))).all()
        return [DueJob(id, started, due, bool(active), bool(good)) for id, started, due, active, good in rows]

    def end_due(self, job_id: str) -> bool:
        """End a job as was entered, at the time that was; False if it was cancelled."""
        query = sa.select(JOBS.c.due, JOBS.c.error).where(JOBS.c.id == job_id)
        with self._engine.begin() as connection:
            due, error = connection.execute(query).one()
            forgotten = JOBS.update().where(JOBS.c.id == job_id, ~ACTIVE)
            connection.execute(forgotten.values(due=None, error=None))
        values = {"due": None, "ended": due}
        if error is None:
            return self._end(job_id, JobState.SUCCEEDED, "finished", fraction=1.0, **values)
        return self._end(job_id, JobState.FAILED, error["detail"], **values)

    def succeed(self, job_id: str) -> bool:
        """End a job whose result is stored."""
        return self._end(job_id, JobState.SUCCEEDED, "finished", fraction=1.0)

    def fail(self, job_id: str, error: Mapping[str, Any]) -> bool:
        """End a job with the error that stopped it."""
        values = {"error": dict(error), "due": None}
        return self._end(job_id, JobState.FAILED, str(error.get("detail", "failed")), **values)

    def cancel(self, job_id: str) -> bool:
        """End a job because its owner asked for it."""
        return self._end(job_id, JobState.CANCELLED, "cancelled")

    def _end(self, job_id: str, state: JobState, message: str, **values: Any) -> bool:
        return self._change(job_id, **{"state": state.value, "message": message, "ended": _now()} | values)

    def _change(self, job_id: str, **values: Any) -> bool:
        update = JOBS.update().where(JOBS.c.id == job_id, ACTIVE).values(**values)
        with self._engine.begin() as connection:
            return connection.execute(update).rowcount == 1


def _job(row: Mapping[str, Any]) -> Job:
    fields = {name: value for name, value in row.items() if name not in _UNSHOWN}
    state = JobState(row["state"])
    error = row["error"] if state is JobState.FAILED else None  # entered before the end of a job that is due
    return Job(**dict(fields, state=state, lane=Lane(row["lane"]), error=error))


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="microseconds")
