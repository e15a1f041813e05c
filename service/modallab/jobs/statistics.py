"""Statistics of all jobs in the book: how many, how long they waited and ran."""

from collections.abc import Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from modallab.store.tables import JOBS


@dataclass(frozen=True)
class Times:
    """Distribution of times."""

    buckets: tuple[int, ...]
    """Number of times up to each bound, not cumulated beyond it."""
    count: int
    """Number of times."""
    total: float
    """s, sum of the times."""


@dataclass(frozen=True)
class JobStatistics:
    """Jobs by task and state, and the times of each task."""

    counts: dict[tuple[str, str], int]
    """Number of jobs by task and state."""
    waits: dict[str, Times]
    """Times until the work began, by task."""
    runs: dict[str, Times]
    """Times from begin to end of the work, by task."""


def job_statistics(engine: sa.Engine, bounds: Sequence[float]) -> JobStatistics:
    """Return the statistics of all jobs in a database.

    Parameters
    ----------
    bounds
        s, rising upper bounds of the buckets of times.
    """
    counted = sa.select(JOBS.c.task, JOBS.c.state, sa.func.count()).group_by(JOBS.c.task, JOBS.c.state)
    with engine.begin() as connection:
        counts = {(task, state): int(n) for task, state, n in connection.execute(counted)}
        waits = _times(connection, JOBS.c.created, JOBS.c.started, bounds)
        runs = _times(connection, JOBS.c.started, JOBS.c.ended, bounds)
    return JobStatistics(counts, waits, runs)


def _times(
    connection: sa.Connection, begin: sa.Column[str], end: sa.Column[str], bounds: Sequence[float]
) -> dict[str, Times]:
    seconds = _second(connection, end) - _second(connection, begin)
    within = [sa.func.sum(sa.case((seconds <= bound, 1), else_=0)) for bound in bounds]
    query = sa.select(JOBS.c.task, sa.func.count(), sa.func.sum(seconds), *within)
    query = query.where(begin.is_not(None), end.is_not(None)).group_by(JOBS.c.task)
    return {
        task: Times(tuple(map(int, buckets)), int(count), float(total))
        for task, count, total, *buckets in connection.execute(query)
    }


def _second(connection: sa.Connection, column: sa.Column[str]) -> sa.ColumnElement[float]:
    """Return a column of ISO 8601 as seconds."""
    if connection.dialect.name == "postgresql":
        moment = sa.cast(column, sa.DateTime(timezone=True))
        return sa.cast(sa.extract("epoch", moment), sa.Double)
    return sa.func.julianday(column) * 86400.0
