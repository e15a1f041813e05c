"""Databases for the tests: a schema of its own in PostgreSQL, a file in SQLite."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import sqlalchemy as sa

from modallab.store.engine import make_engine

DATABASES = ("sqlite", "postgresql")
_URL = os.environ.get(
    "MODALLAB_TEST_DATABASE_URL", "postgresql://postgres@127.0.0.1:5432/test?connect_timeout=2"
)


@contextmanager
def database(kind: str, folder: Path) -> Iterator[tuple[str, str]]:
    """Yield URL and schema of an empty database; skip the test where there is none."""
    if kind == "sqlite":
        yield f"sqlite:///{folder / 'modallab.sqlite'}", "unused"
        return
    schema = f"test_{secrets.token_hex(6)}"
    engine = make_engine(_URL, schema=schema)
    try:
        engine.connect().close()
    except sa.exc.OperationalError as error:
        pytest.skip(
            f"NO POSTGRESQL TESTED: none reachable at {_URL} (MODALLAB_TEST_DATABASE_URL): {error.orig}"
        )
    try:
        yield _URL, schema
    finally:
        with engine.begin() as connection:
            for name in (schema, f"{schema}_jobs"):
                connection.execute(sa.schema.DropSchema(name, cascade=True, if_exists=True))
        engine.dispose()
