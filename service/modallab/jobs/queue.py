"""Order of the queue: owners take turns, in a lane of short jobs and in one of long jobs.

Whoever queues a hundred jobs gets a hundred turns, one after another; whoever comes later gets the turn
that the lane is at, before all but one of them. A turn is fixed when the job is queued, so that the engine of
jobs needs nothing but to sort by it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from statistics import median

import sqlalchemy as sa

from modallab.jobs.runner import Job, JobState, Lane, QueueFullError, QueueQuotaError
from modallab.jobs.settings import JOB
from modallab.store.quotas import Quotas
from modallab.store.tables import JOBS

ACTIVE = JOBS.c.state.in_([JobState.QUEUED.value, JobState.RUNNING.value])


def next_turn(owner: str, lane: Lane) -> sa.ScalarSelect[int]:
    """Return the turn of an owner's next job: the lane's present one, or the one after the owner's last.

    Jobs that were cancelled while they waited have used no turn.
    """
    in_lane, began = JOBS.c.lane == lane.value, JOBS.c.started.is_not(None)
    present = sa.select(sa.func.max(JOBS.c.turn).label("turn")).where(in_lane, began)
    own = sa.select((sa.func.max(JOBS.c.turn) + 1).label("turn"))
    own = own.where(in_lane, JOBS.c.owner == owner, sa.or_(began, ACTIVE))
    turns = sa.union_all(present, own).subquery()
    return sa.select(sa.func.coalesce(sa.func.max(turns.c.turn), 0)).scalar_subquery()


def check_room(connection: sa.Connection, owner: str, queue_length: int, quotas: Quotas) -> None:
    """Raise if more jobs wait than may: of the owner, of the class, or of all."""
    waiting = sa.select(sa.func.count()).where(JOBS.c.state == JobState.QUEUED.value)
    if (excess := quotas.excess(connection, owner, JOBS.c.owner, waiting)) is not None:
        name, quota = excess
        raise QueueQuotaError(f"as many jobs of this {name} wait as may", allowed=quota)
    if connection.execute(waiting).scalar_one() > queue_length:
        raise QueueFullError("as many jobs wait as may", allowed=queue_length)


def with_places(connection: sa.Connection, jobs: list[Job]) -> list[Job]:
    """Return jobs, those that wait with their places in their lanes and the times until they begin."""
    lanes = {job.lane for job in jobs if job.state is JobState.QUEUED}
    if not lanes:
        return jobs
    query = sa.select(JOBS.c.id, JOBS.c.task, JOBS.c.state, JOBS.c.lane).where(
        ACTIVE, JOBS.c.lane.in_(lane.value for lane in lanes)
    )
    active = connection.execute(query.order_by(JOBS.c.turn, JOBS.c.created, JOBS.c.id)).all()
    durations = {task: _usual_duration(connection, task) for task in {row.task for row in active}}
    placed: dict[str, tuple[int, float | None]] = {}
    for lane in lanes:
        rows = [row for row in active if row.lane == lane.value]
        under_way = [row.task for row in rows if row.state == JobState.RUNNING.value]
        waiting = [row for row in rows if row.state == JobState.QUEUED.value]
        tasks = [row.task for row in waiting]
        for n, row in enumerate(waiting):
            placed[row.id] = n + 1, _wait(tasks[:n], under_way, durations)
    return [
        replace(job, place=placed[job.id][0], wait_estimate=placed[job.id][1]) if job.id in placed else job
        for job in jobs
    ]


def _usual_duration(connection: sa.Connection, task: str) -> float | None:
    """Return the median time, s, of the latest jobs of a task; None if there was none."""
    query = sa.select(JOBS.c.started, JOBS.c.ended).where(
        JOBS.c.task == task, JOBS.c.state == JobState.SUCCEEDED.value, JOBS.c.started.is_not(None)
    )
    latest = connection.execute(query.order_by(JOBS.c.ended.desc()).limit(JOB.latest_jobs)).all()
    durations = [
        (datetime.fromisoformat(ended) - datetime.fromisoformat(started)).total_seconds()
        for started, ended in latest
        if ended is not None
    ]
    return median(durations) if durations else None


def _wait(
    before: Sequence[str], under_way: Sequence[str], durations: Mapping[str, float | None]
) -> float | None:
    """Return the time, s, until a job may begin: what is before it, shared by as many as work now."""
    known = [durations[name] for name in before]
    half_done = [durations[name] for name in under_way]
    if any(duration is None for duration in (*known, *half_done)):
        return None
    work = sum(filter(None, known)) + sum(filter(None, half_done)) / 2
    return work / max(1, len(under_way))
