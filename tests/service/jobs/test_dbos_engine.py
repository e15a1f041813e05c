"""The engine of jobs as the reconciler asks it."""

import threading

import pytest
import sqlalchemy as sa

from modallab.jobs.dbos_engine import connected
from modallab.jobs.outages import is_outage
from modallab.store.engine import make_engine
from tests.faults.site import Gate
from tests.service.jobs.lasting import Places


def test_a_client_of_the_engine_raises_at_once_where_the_database_is_away(places: Places) -> None:
    """It would wait without end otherwise, and with it signs of life and the end of the process."""
    url = sa.make_url(places[1].url)
    if url.get_backend_name() == "sqlite":
        pytest.skip("a file is not away")
    gate = Gate(url.host or "127.0.0.1", url.port or 5432)
    gated = url.set(host="127.0.0.1", port=gate.port).render_as_string(hide_password=False)
    engine = make_engine(gated, schema=places[1].schema)
    client = connected(engine, places[1].schema)
    errors: list[BaseException] = []

    def ask() -> None:
        try:
            client.list_workflows(name="job")
        except sa.exc.DBAPIError as error:
            errors.append(error)

    asking = threading.Thread(target=ask, daemon=True)
    with gate.shut():
        asking.start()
        asking.join(20.0)  # s: two attempts to connect
        assert [is_outage(error) for error in errors] == [True]
    client.destroy()
    engine.dispose()
    gate.close()
