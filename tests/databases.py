"""Databases for the tests: a schema of its own in PostgreSQL, a file in SQLite."""

import atexit
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import pytest
import sqlalchemy as sa

from modallab.store.engine import make_engine

DATABASES = ("sqlite", "postgresql")
_URL = os.environ.get(
    "MODALLAB_TEST_DATABASE_URL", "postgresql://postgres@127.0.0.1:5432/test?connect_timeout=2"
)


@cache
def _url_of_own_database() -> str:
    """Return the URL of a database of this process, or the shared one where it may not make any.

    An index that is made concurrently waits for every transaction of its database: in one that all processes
    share the set-up of a test took 48 s, in one of its own it takes 3 s.
    """
    shared = sa.make_url(_URL)
    name = f"{shared.database}_{secrets.token_hex(6)}"
    server = make_engine(_URL, schema="public")

    def execute(statement: str) -> None:
        with server.connect() as connection:
            connection.execution_options(isolation_level="AUTOCOMMIT").execute(sa.text(statement))

    try:
        execute(f"CREATE DATABASE {name} TEMPLATE template0")
    except sa.exc.ProgrammingError:
        return _URL
    atexit.register(execute, f"DROP DATABASE IF EXISTS {name} WITH (FORCE)")
    return shared.set(database=name).render_as_string(hide_password=False)


@contextmanager
def database(kind: str, folder: Path) -> Iterator[tuple[str, str]]:
    """Yield URL and schema of an empty database; skip the test where there is none."""
    if kind == "sqlite":
        yield f"sqlite:///{folder / 'modallab.sqlite'}", "unused"
        return
    try:
        url = _url_of_own_database()
    except sa.exc.OperationalError as error:
        pytest.skip(
            f"NO POSTGRESQL TESTED: none reachable at {_URL} (MODALLAB_TEST_DATABASE_URL): {error.orig}"
        )
    schema = f"test_{secrets.token_hex(6)}"
    engine = make_engine(url, schema=schema)
    try:
        yield url, schema
    finally:
        with engine.begin() as connection:
            for name in (schema, f"{schema}_jobs"):
                connection.execute(sa.schema.DropSchema(name, cascade=True, if_exists=True))
        engine.dispose()
