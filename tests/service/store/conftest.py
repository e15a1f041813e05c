"""Stores to test: SQLite in a folder always, PostgreSQL where one is reachable."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from modallab.store.place import StorePlace, engine_of, open_store
from modallab.store.sql import SqlStore
from tests.databases import DATABASES, database


@pytest.fixture(params=DATABASES)
def place(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[StorePlace]:
    """A prepared place of its own, gone afterwards."""
    with database(request.param, tmp_path) as (url, schema):
        place = StorePlace(url, schema, tmp_path / "arrays")
        place.prepare()
        yield place
        engine_of(place).dispose()


@pytest.fixture
def store(place: StorePlace) -> SqlStore:
    """A store with nothing in it."""
    return open_store(place)
