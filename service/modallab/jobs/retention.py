"""Retention: jobs that ended long ago, and results that nobody named, are removed."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any, Protocol

import structlog

from modallab.jobs.book import JobBook
from modallab.store.arrays import FolderArrays
from modallab.store.place import StorePlace, engine_of
from modallab.store.retention import remove_unnamed
from modallab.store.tables import THINGS
from modallab.store.trash import empty_trash, expired_before

_log = structlog.get_logger()
_AT_ONCE = 500  # jobs named in one statement


class Forgetful(Protocol):
    """What the retention asks of the engine of jobs."""

    def forget(self, job_ids: Sequence[str]) -> None:
        """Remove what is known of jobs that have ended."""
        ...


@dataclass(frozen=True)
class Retention:
    """How long jobs and unnamed things of a lab are kept."""

    book: JobBook
    place: StorePlace
    days: float | None
    """Days after which they are removed; None: only what was deleted and cannot be restored is."""

    def sweep(self, engine: Forgetful, *, now: datetime | None = None) -> tuple[int, int]:
        """Return the numbers of jobs and of things that were removed because they are older than that.

        A thing stays while it has a name, a label or a comment, is shared with a class, something else was
        made from it, or a job that has not ended needs it; in the trash it stays for a day.
        """
        time = now or datetime.now(UTC)
        engine_of_store, files = engine_of(self.place), FolderArrays(self.place.folder)
        emptied = empty_trash(engine_of_store, files, THINGS.c.removed < expired_before(time))
        if emptied:
            _log.info("emptied the trash", things=emptied)
        if self.days is None:
            return 0, emptied
        jobs, things = self._sweep_old(engine, time - timedelta(days=self.days))
        return jobs, things + emptied

    def _sweep_old(self, engine: Forgetful, time: datetime) -> tuple[int, int]:
        before = time.isoformat(timespec="microseconds")
        jobs = self.book.ended_before(before)
        for first in range(0, len(jobs), _AT_ONCE):
            some = jobs[first : first + _AT_ONCE]
            # The engine first: what it has forgotten and the book has not is found again the next time.
            engine.forget(some)
            self.book.remove(some)
        needed = {text for arguments in self.book.needs() for text in _texts(arguments)}
        engine_of_store, files = engine_of(self.place), FolderArrays(self.place.folder)
        things = remove_unnamed(engine_of_store, files, before, needed)
        if jobs or things:
            _log.info("removed what is old", jobs=len(jobs), things=things)
        return len(jobs), things


def _texts(value: Any) -> Iterator[str]:
    """Yield every text in a JSON value: the ids among them are those of things."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for entry in value.values():
            yield from _texts(entry)
    elif isinstance(value, list):
        for entry in value:
            yield from _texts(entry)
