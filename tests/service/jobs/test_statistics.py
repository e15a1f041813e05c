"""Statistics of jobs, equal in both databases."""

import pytest
import sqlalchemy as sa

from modallab.jobs.book import JobBook
from modallab.jobs.durable import JobPlace
from modallab.jobs.statistics import job_statistics
from modallab.store.place import StorePlace, engine_of
from modallab.store.tables import JOBS


def test_times_fall_into_buckets(places: tuple[StorePlace, JobPlace]) -> None:
    engine = engine_of(places[0])
    book = JobBook(engine, queue_length=10)
    assert job_statistics(engine, (1.0,)).counts == {}
    for second in (0, 2, 5):
        job = book.open("task", {}, owner="me")
        book.start(job.id)
        book.succeed(job.id)
        moments = {"created": "00:00", "started": "00:01", "ended": f"00:0{1 + second}"}
        values = {name: f"2026-01-01T00:{moment}.500000+00:00" for name, moment in moments.items()}
        with engine.begin() as connection:
            connection.execute(sa.update(JOBS).where(JOBS.c.id == job.id).values(**values))
    book.open("task", {}, owner="me")
    found = job_statistics(engine, (0.5, 3.0))
    assert found.counts == {("task", "succeeded"): 3, ("task", "queued"): 1}
    for times, buckets, total in ((found.runs, (1, 2), 7.0), (found.waits, (0, 3), 3.0)):
        assert (times["task"].buckets, times["task"].count) == (buckets, 3)
        assert times["task"].total == pytest.approx(total, abs=1e-3)  # days in double precision
