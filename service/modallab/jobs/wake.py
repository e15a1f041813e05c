"""Calls that wake whoever looks for queued jobs, so that looking may be seldom while nothing happens."""

import threading
import time
from contextlib import suppress

import sqlalchemy as sa
import structlog

from modallab.jobs.settings import JOB
from modallab.store.engine import server_arguments

_log = structlog.get_logger()


class Bell:
    """Tells the threads of a process that a job may wait: they look often for a while, then seldom."""

    def __init__(self) -> None:
        self._condition = threading.Condition()
        self._rings = 0
        self._rung = time.monotonic()

    def ring(self) -> None:
        """Wake every thread that waits."""
        with self._condition:
            self._rings += 1
            self._rung = time.monotonic()
            self._condition.notify_all()

    @property
    def rings(self) -> int:
        """Number of rings so far."""
        return self._rings

    def wait(self, stop: threading.Event, rings: int) -> None:
        """Return when it is time to look again, at the next ring, or soon after `stop` is set.

        Parameters
        ----------
        rings
            Number of rings after which the caller looked last.
        """
        with self._condition:
            recent = time.monotonic() - self._rung < JOB.attentive
            end = time.monotonic() + (JOB.polling_interval if recent else JOB.idle_interval)
            while rings == self._rings and not stop.is_set() and (left := end - time.monotonic()) > 0:
                self._condition.wait(min(left, JOB.longest_stop))


class Listener:
    """Stands in for the event that ends a polling thread: its `wait` ends at a ring, too."""

    def __init__(self, stop: threading.Event, bell: Bell) -> None:
        self._stop, self._bell, self._rings = stop, bell, bell.rings

    def is_set(self) -> bool:
        """Return whether the thread has to end."""
        return self._stop.is_set()

    def wait(self, timeout: float | None = None) -> bool:
        """Return whether the thread has to end, when it is time to look or to end."""
        self._bell.wait(self._stop, self._rings)
        self._rings = self._bell.rings
        return self._stop.is_set()


class Notifier:
    """Rings the bells of all processes that share a database; without PostgreSQL that of this process.

    Parameters
    ----------
    engine
        Engine of the jobs' database.
    channel
        Name that tells this lab's calls from those of others in the same database.
    bell
        Bell of this process.
    """

    def __init__(self, engine: sa.Engine, channel: str, bell: Bell) -> None:
        self._engine, self._channel, self._bell = engine, channel, bell
        self._shared = engine.dialect.name == "postgresql"
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._listen, name="listener", daemon=True)

    def ring(self) -> None:
        """Wake whoever looks for jobs; a call that is lost costs some seconds."""
        self._bell.ring()
        if self._shared:
            with suppress(sa.exc.DBAPIError), self._engine.begin() as connection:
                connection.execute(sa.select(sa.func.pg_notify(self._channel, "")))

    def listen(self) -> None:
        """Hear the calls of other processes from now on."""
        if self._shared:
            self._thread.start()

    def end(self) -> None:
        """Hear no more."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()

    def _listen(self) -> None:
        import psycopg

        url = self._engine.url.set(drivername="postgresql").render_as_string(hide_password=False)
        while not self._ended.is_set():
            try:
                with psycopg.connect(url, autocommit=True, **server_arguments()) as connection:
                    connection.execute(f'LISTEN "{self._channel}"')
                    self._bell.ring()  # for what was called meanwhile
                    while not self._ended.is_set():
                        for _ in connection.notifies(timeout=JOB.longest_stop, stop_after=1):
                            self._bell.ring()
            except psycopg.Error as error:
                _log.warning("calls of other processes are not heard", error=str(error).splitlines()[0])
                self._ended.wait(JOB.longest_outage_pause)
