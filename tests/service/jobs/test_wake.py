"""Calls wake whoever looks for jobs, in this process and in others; without a call looks are seldom."""

import threading
import time
from collections.abc import Callable
from functools import partial

import anyio
import psycopg
import pytest
from anyio import to_thread

from modallab.jobs.book import JobBook
from modallab.jobs.durable import DurableRunner, JobPlace
from modallab.jobs.settings import JOB
from modallab.jobs.wake import Bell, Listener, Notifier
from modallab.store.engine import make_engine
from modallab.store.place import StorePlace, engine_of

Places = tuple[StorePlace, JobPlace]
AT_ONCE = 2.0  # s; a look that nobody called for would be 4 s later


def seconds(wait: Callable[[], object]) -> float:
    begin = time.monotonic()
    wait()
    return time.monotonic() - begin


def until(reached: Callable[[], bool]) -> bool:
    """Return whether something comes true within seconds."""
    end = time.monotonic() + 10
    while not reached() and time.monotonic() < end:
        time.sleep(0.02)
    return reached()


def quiet_bell() -> Bell:
    """Return a bell whose last ring is long ago."""
    bell = Bell()
    bell._rung -= JOB.attentive
    return bell


def test_looks_are_frequent_after_a_ring_and_seldom_later() -> None:
    bell = Bell()
    bell.ring()
    listener = Listener(threading.Event(), bell)
    assert seconds(listener.wait) < 2 * JOB.polling_interval + 0.5  # on a busy machine
    bell._rung -= JOB.attentive
    threading.Timer(1.0, bell.ring).start()
    assert 0.9 < seconds(listener.wait) < JOB.idle_interval - 1


def test_a_ring_before_the_wait_is_not_lost() -> None:
    listeners = []
    for _ in range(5):  # of which a busy machine may be late with some
        bell = quiet_bell()
        listeners.append(listener := Listener(threading.Event(), bell))
        bell.ring()
    assert min(seconds(listener.wait) for listener in listeners) < 0.09 < JOB.polling_interval
    assert not listener.is_set()


def test_who_waits_sees_soon_that_it_has_to_end() -> None:
    stop = threading.Event()
    listener = Listener(stop, quiet_bell())
    threading.Timer(0.1, stop.set).start()
    assert seconds(listener.wait) < JOB.longest_stop + 1.0 < JOB.idle_interval  # on a busy machine
    assert listener.is_set()


def test_a_call_reaches_the_process_that_works(places: Places) -> None:
    """In PostgreSQL another bell stands for another process; SQLite has none."""
    engine = make_engine(places[1].url, schema=places[1].schema)
    here, there = quiet_bell(), quiet_bell()
    listening = Notifier(engine, places[1].schema, there)
    listening.listen()
    try:
        shared = engine.dialect.name == "postgresql"
        assert until(lambda: not shared or there.rings > 0)  # it rings when it has begun to listen
        heard = there.rings
        Notifier(engine, places[1].schema, here).ring()
        assert here.rings == 1
        assert until(lambda: there.rings == heard + shared)
    finally:
        listening.end()
        engine.dispose()


@pytest.mark.filterwarnings("ignore:Exception ignored in. <function BaseConnection.__del__")
def test_a_job_starts_at_once_although_looks_are_seldom(places: Places) -> None:
    book = JobBook(engine_of(places[0]), queue_length=10)

    async def main() -> float:
        async with DurableRunner(book, *places, executor_id="test") as runner:
            submit = partial(
                runner.submit, "update_and_store", {}, owner="me"
            )  # without inputs: fails at once
            seconds = 0.0
            # The first one starts the worker process; of the others one at once is enough on a busy machine.
            for pause in (0.0, *(JOB.attentive + 0.7,) * 3):
                await anyio.sleep(pause)
                job = await to_thread.run_sync(submit)
                begin = time.monotonic()
                while not book.get(job.id).state.final and time.monotonic() - begin < 30:
                    await anyio.sleep(0.02)
                assert book.get(job.id).state.final
                seconds = time.monotonic() - begin
                if pause and seconds < AT_ONCE:
                    break
            return seconds

    assert anyio.run(main) < AT_ONCE


def test_who_listens_soon_notices_that_it_was_cut_off(
    places: Places, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A host that was cut off has heard nothing since; without probes it would not for two hours."""
    engine = make_engine(places[1].url, schema=places[1].schema)
    if engine.dialect.name != "postgresql":
        pytest.skip("SQLite has no connections")
    opened: list[psycopg.ConnectionInfo] = []
    connect = psycopg.connect

    def noted(*given: object, **more: object) -> psycopg.Connection:
        connection = connect(*given, **more)  # type: ignore[arg-type]
        opened.append(connection.info)
        return connection

    monkeypatch.setattr(psycopg, "connect", noted)
    listening = Notifier(engine, places[1].schema, quiet_bell())
    listening.listen()
    assert until(lambda: bool(opened))
    given = opened[0].get_parameters()
    listening.end()
    idle, interval, count = (int(given[f"keepalives_{name}"]) for name in ("idle", "interval", "count"))
    assert idle + interval * count <= 30  # s, as soon as jobs of a lost host move
    assert int(given["connect_timeout"]) <= 10  # s: at its end the process waits for this thread
