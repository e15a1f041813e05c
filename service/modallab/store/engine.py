"""Database engines: SQLite beside the service, PostgreSQL when scaled."""

import sqlite3
from types import ModuleType
from typing import Any

import sqlalchemy as sa
from sqlalchemy import event

# The job engine needs SQLite 3.42; Debian 12's Python links 3.40.
_OLDEST_SQLITE = (3, 42)
_CONNECT_TIMEOUT = 5  # s: a server that does not answer is told as away while the request waits
# A host that is cut off says no goodbye. What it has locked is free, and what waits for an answer on it goes
# on, when three probes in 25 s have come to nothing; without, after two hours.
_PROBES = {"keepalives_idle": 10, "keepalives_interval": 5, "keepalives_count": 3}
_UNANSWERED = 25_000  # ms for which what was sent may stay unacknowledged


def _sqlite_module() -> ModuleType:
    if sqlite3.sqlite_version_info >= _OLDEST_SQLITE:
        return sqlite3
    import pysqlite3.dbapi2

    module: ModuleType = pysqlite3.dbapi2
    return module


def make_engine(url: str, *, schema: str) -> sa.Engine:
    """Return an engine for a database URL.

    Parameters
    ----------
    url
        `sqlite:///file` or `postgresql://user:password@host/database`.
    schema
        Schema to work in; SQLite has none and ignores it.
    """
    parsed = sa.make_url(url)
    if parsed.get_backend_name() == "sqlite":
        return _sqlite_engine(parsed)
    return sa.create_engine(
        parsed.set(drivername="postgresql+psycopg"),
        connect_args=server_arguments(search_path=schema),
        pool_pre_ping=True,
        pool_size=10,
        max_overflow=30,  # as many as the web server's threads
    )


def server_arguments(**settings: str) -> dict[str, Any]:
    """Return arguments of a connection to a database server: both ends soon notice that the other is gone.

    Parameters
    ----------
    settings
        Settings of the server for this connection.
    """
    server: dict[str, Any] = settings | {"tcp_user_timeout": _UNANSWERED}
    server |= {f"tcp_{name}": value for name, value in _PROBES.items()}
    return {
        "options": " ".join(f"-c{name}={value}" for name, value in server.items()),
        "connect_timeout": _CONNECT_TIMEOUT,
        "tcp_user_timeout": _UNANSWERED,
        **_PROBES,
    }


def _sqlite_engine(url: sa.URL) -> sa.Engine:
    engine = sa.create_engine(url, module=_sqlite_module(), pool_size=10, max_overflow=30)

    @event.listens_for(engine, "connect")
    def prepare(connection: Any, _record: Any) -> None:
        # Writers queue up from their first statement on; a deferred transaction that turns
        # into a writer fails at once with "database is locked".
        connection.isolation_level = "IMMEDIATE"
        connection.execute("PRAGMA busy_timeout=30000")
        connection.execute("PRAGMA foreign_keys=ON")
        connection.execute("PRAGMA journal_mode=WAL")
        connection.execute("PRAGMA synchronous=NORMAL")

    return engine
