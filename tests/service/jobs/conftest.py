"""Places for jobs: SQLite in a folder always, PostgreSQL where one is reachable."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from modallab.jobs.book import JobBook
from modallab.jobs.durable import JobPlace
from modallab.store.place import StorePlace, engine_of
from tests.databases import DATABASES, database


@pytest.fixture(params=DATABASES)
def places(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[tuple[StorePlace, JobPlace]]:
    """Where things and jobs are, prepared, and gone afterwards."""
    with database(request.param, tmp_path) as (url, schema):
        jobs_url = f"sqlite:///{tmp_path / 'jobs.sqlite'}" if request.param == "sqlite" else url
        things, jobs = StorePlace(url, schema, tmp_path / "arrays"), JobPlace(jobs_url, f"{schema}_jobs")
        things.prepare()
        jobs.prepare()
        yield things, jobs
        engine_of(things).dispose()


@pytest.fixture
def place(tmp_path: Path) -> Iterator[StorePlace]:
    """Where things are, embedded, prepared, and gone afterwards."""
    place = StorePlace(f"sqlite:///{tmp_path / 'modallab.sqlite'}", "unused", tmp_path / "arrays")
    place.prepare()
    yield place
    engine_of(place).dispose()


@pytest.fixture
def book(place: StorePlace) -> JobBook:
    """The book of the jobs there."""
    return JobBook(engine_of(place), queue_length=10)
