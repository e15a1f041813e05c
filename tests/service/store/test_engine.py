"""Connections to a database server."""

from pathlib import Path

import sqlalchemy as sa

from modallab.store.engine import make_engine
from tests.databases import database

NOTICED = 30.0  # s, as soon as jobs of a lost host move


def test_a_server_soon_notices_that_a_host_was_cut_off(tmp_path: Path) -> None:
    with database("postgresql", tmp_path) as (url, schema):
        engine = make_engine(url, schema=schema)
        with engine.begin() as connection:
            idle, interval, count = (
                int(
                    connection.execute(
                        sa.text(f"SELECT current_setting('tcp_keepalives_{name}')")
                    ).scalar_one()
                )
                for name in ("idle", "interval", "count")
            )
            unanswered = sa.text("SELECT setting FROM pg_settings WHERE name = 'tcp_user_timeout'")
            milliseconds = int(connection.execute(unanswered).scalar_one())
        engine.dispose()
        assert 0 < idle + interval * count <= NOTICED  # 0 is two hours
        assert 0 < milliseconds <= 1e3 * NOTICED  # probes wait while something is unacknowledged
