"""Place of the store, with which any process opens it."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import sqlalchemy as sa

from modallab.store.arrays import FolderArrays
from modallab.store.engine import make_engine
from modallab.store.sql import SqlStore


@dataclass(frozen=True)
class StorePlace:
    """A database and a folder, as plain values that travel to other processes."""

    url: str
    schema: str  # of PostgreSQL
    folder: Path  # for array files

    def prepare(self) -> None:
        """Create the folder and the tables, or bring the tables up to date."""
        from modallab.store.migrate import migrate  # alembic: no process that only reads and writes needs it

        self.folder.mkdir(parents=True, exist_ok=True)
        migrate(engine_of(self), schema=self.schema)


@lru_cache(maxsize=8)
def engine_of(place: StorePlace) -> sa.Engine:
    """Return this process's engine for a place."""
    return make_engine(place.url, schema=place.schema)


def open_store(place: StorePlace) -> SqlStore:
    """Return the store at a place."""
    return SqlStore(engine_of(place).begin, FolderArrays(place.folder))
