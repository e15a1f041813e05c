"""Executors: processes that run jobs, and whether they live.

Each raises a counter in the database every few seconds. Another takes it for lost whose counter has stood
still for long by its own monotonic clock: no two clocks are compared, and a clock that is set does nothing.
"""

import os
import platform
import secrets
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import psutil
import sqlalchemy as sa

from modallab.core.errors import ModalLabError
from modallab.jobs.settings import JOB
from modallab.store.rows import insert_once
from modallab.store.tables import EXECUTORS


class ExecutorTakenError(ModalLabError):
    """Another process runs jobs under this name."""

    code = "executor_taken"


@dataclass(frozen=True)
class Executor:
    """A process that runs jobs."""

    id: str
    """Name, unique among the executors of a database."""
    holder: str
    """Random word that tells two processes of one name apart."""
    host: str
    """Machine and process namespace in which `pid` counts."""
    pid: int
    """Id of the process."""
    beat: int = 0
    """Number that rises while the process lives."""

    @classmethod
    def here(cls, id: str | None = None) -> "Executor":
        """Return this process as an executor, its name made from host and process unless it has one."""
        holder = secrets.token_hex(8)
        return cls(id or f"{platform.node()}-{os.getpid()}-{holder[:6]}", holder, _host(), os.getpid())

    @property
    def dead(self) -> bool:
        """Whether the process has certainly ended; False where it runs on another host."""
        return self.host == _host() and self.pid != os.getpid() and not psutil.pid_exists(self.pid)


def _host() -> str:
    """Return a name of this machine since its start, and of the process namespace in it."""
    parts = [platform.node()]
    with suppress(OSError):
        parts.append(Path("/proc/sys/kernel/random/boot_id").read_text().strip())
        parts.append(os.readlink("/proc/self/ns/pid"))
    return " ".join(parts)


class ExecutorBook:
    """The executors of a database."""

    def __init__(self, engine: sa.Engine) -> None:
        self._engine = engine

    def all(self) -> list[Executor]:
        """Return every executor that has not left."""
        with self._engine.begin() as connection:
            return [Executor(**row._mapping) for row in connection.execute(sa.select(EXECUTORS))]

    def enter(self, executor: Executor, *, sleep: Callable[[float], None] = time.sleep) -> None:
        """Enter an executor; a lost one of its name makes room.

        Raises
        ------
        ExecutorTakenError
            If a process of that name lives.
        """
        watch = Watch()
        while not self._entered(executor):
            former = next((other for other in self.all() if other.id == executor.id), executor)
            if former.dead or former in watch.lost([former]):
                self.remove(former)
                continue
            if watch.has_moved(former):
                raise ExecutorTakenError(
                    f"another process runs jobs as {executor.id!r}: give this one another name",
                    field="executor_id",
                    value=executor.id,
                )
            sleep(JOB.beat_interval / 2)

    def _entered(self, executor: Executor) -> bool:
        row = {name: getattr(executor, name) for name in EXECUTORS.c.keys()}  # noqa: SIM118
        with self._engine.begin() as connection:
            return insert_once(connection, EXECUTORS, row)

    def beat(self, executor: Executor) -> bool:
        """Show that an executor lives; False if another holds its name.

        One that was taken for lost, as after a long pause of its machine, is entered again.
        """
        with self._engine.begin() as connection:
            update = EXECUTORS.update().where(_is(executor)).values(beat=EXECUTORS.c.beat + 1)
            if connection.execute(update).rowcount == 1:
                return True
        return self._entered(executor)

    def remove(self, executor: Executor) -> None:
        """Remove an executor that has left or is lost."""
        with self._engine.begin() as connection:
            connection.execute(EXECUTORS.delete().where(_is(executor)))


def _is(executor: Executor) -> sa.ColumnElement[bool]:
    return sa.and_(EXECUTORS.c.id == executor.id, EXECUTORS.c.holder == executor.holder)


@dataclass
class Watch:
    """Watches the counters of executors."""

    clock: Callable[[], float] = time.monotonic
    """Seconds, never set back."""
    _looked: float | None = None
    _seen: dict[tuple[str, str], tuple[int, int, float]] = field(default_factory=dict)

    def lost(self, executors: list[Executor]) -> list[Executor]:
        """Return the executors that have ended, or whose counters have stood still for long."""
        now = self.clock()
        # While the database was away no counter could rise.
        blind = max(0.0, now - self._looked - JOB.lost_after / 2) if self._looked is not None else 0.0
        self._looked = now
        for executor in executors:
            key = executor.id, executor.holder
            first, last, since = self._seen.get(key, (executor.beat, executor.beat, now))
            self._seen[key] = first, executor.beat, since + blind if last == executor.beat else now
        return [
            executor
            for executor in executors
            if executor.dead or now - self._seen[executor.id, executor.holder][2] > JOB.lost_after
        ]

    def has_moved(self, executor: Executor) -> bool:
        """Return whether a counter has risen since it was first seen."""
        first, last, _ = self._seen.get((executor.id, executor.holder), (executor.beat, executor.beat, 0.0))
        return last > first
