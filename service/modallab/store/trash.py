"""Trash: what was deleted, until it is restored or removed for good."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, fields
from datetime import UTC, datetime, timedelta
from typing import Any

import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError

from modallab.core.errors import NotFoundError
from modallab.core.settings import Settings, setting
from modallab.store.arrays import ArrayFiles
from modallab.store.base import Discarded, Entry, InTrashError, InUseError
from modallab.store.tables import LINKS, THINGS, TRUTHS
from modallab.store.uses import is_used, lock_untrashed, users
from modallab.store.viewer import Viewer, manageable

Connect = Callable[[], AbstractContextManager[sa.Connection]]


@dataclass(frozen=True)
class TrashSettings(Settings):
    """Time that things spend in the trash."""

    hours: float = setting(
        24.0,
        unit="h",
        doc="time in which what was deleted can be restored",
        derived="a day: a slip is noticed by the next session",
    )


TRASH = TrashSettings()
_ENTRY = [THINGS.c[field.name] for field in fields(Entry)]


def _written(time: datetime) -> str:
    return time.isoformat(timespec="microseconds")


def expired_before(now: datetime) -> str:
    """Return the ISO time before which things were deleted that cannot be restored any more."""
    return _written(now - timedelta(hours=TRASH.hours))


def _until(removed: str) -> str:
    return _written(datetime.fromisoformat(removed) + timedelta(hours=TRASH.hours))


def _is_restorable() -> sa.ColumnElement[bool]:
    return THINGS.c.removed > expired_before(datetime.now(UTC))


def discard(connection: sa.Connection, id: str, viewer: Viewer) -> bool:
    """Move a thing to the trash, and tell whether it is the viewer's to remove.

    Raises
    ------
    InUseError
        If something else that is not in the trash was made from it.
    """
    condition = (THINGS.c.id == id) & THINGS.c.removed.is_(None) & manageable(THINGS.c.owner, viewer)
    change = THINGS.update().where(condition).values(removed=_written(datetime.now(UTC)))
    # First the change, which waits for whoever is about to use the thing, and then the question.
    if connection.execute(change.returning(THINGS.c.id)).first() is None:
        return False
    if connection.execute(sa.select(is_used(id))).scalar_one():
        raise InUseError(f"{id!r} is what something else was made from", value=id)
    return True


def absence(connection: sa.Connection, kind: str, id: str, viewer: Viewer) -> NotFoundError:
    """Return the error that says that a thing is not there, or in the trash and until when."""
    condition = (THINGS.c.id == id) & (THINGS.c.kind == kind) & manageable(THINGS.c.owner, viewer)
    removed = connection.execute(sa.select(THINGS.c.removed).where(condition, _is_restorable())).scalar()
    if removed is None:
        return NotFoundError(f"there is no {kind} {id!r}", field=f"{kind}_id", value=id)
    until = _until(removed)
    return NotFoundError(
        f"the {kind} {id!r} is in the trash until {until}", field=f"{kind}_id", value=id, until=until
    )


def take_out(connection: sa.Connection, kind: str, id: str, owner: str) -> None:
    """Take a thing out of the trash that its owner makes anew under the same id."""
    condition = (THINGS.c.id == id) & (THINGS.c.kind == kind) & (THINGS.c.owner == owner)
    connection.execute(THINGS.update().where(condition).values(removed=None))


class SqlTrash:
    """What a viewer has deleted, or may restore for others."""

    def __init__(self, connect: Connect, files: ArrayFiles, viewer: Viewer) -> None:
        self._connect, self._files, self._viewer = connect, files, viewer

    def list(self, *, owner: str, limit: int, cursor: str | None = None) -> list[Discarded]:
        """Return what an owner has in the trash, last deleted first, what was deleted before `cursor`."""
        age = sa.tuple_(THINGS.c.removed, THINGS.c.id)
        query = sa.select(*_ENTRY, THINGS.c.removed).where(self._restorable(), THINGS.c.owner == owner)
        query = query.order_by(THINGS.c.removed.desc(), THINGS.c.id.desc()).limit(limit)
        with self._connect() as connection:
            if cursor is not None:
                last = sa.select(THINGS.c.removed, THINGS.c.id).where(THINGS.c.id == cursor)
                row = connection.execute(last.where(self._restorable())).first()
                if row is None:
                    raise self._absence(cursor)
                query = query.where(age < sa.tuple_(*row))
            return [_discarded(row._asdict()) for row in connection.execute(query)]

    def restore(self, id: str) -> Entry:
        """Return the entry of a thing that is taken out of the trash.

        Raises
        ------
        NotFoundError
            If it is not in the viewer's trash.
        InTrashError
            If something that it was made from is in the trash, too.
        """
        change = THINGS.update().where(THINGS.c.id == id, self._restorable()).values(removed=None)
        made_from = sa.select(LINKS.c.target).where(LINKS.c.source == id)
        tested = sa.select(TRUTHS.c.structure_id).where(TRUTHS.c.measurement_id == id)
        with self._connect() as connection:
            row = connection.execute(change.returning(*_ENTRY)).first()
            if row is None:
                raise self._absence(id)
            if not lock_untrashed(connection, set(connection.execute(made_from.union(tested)).scalars())):
                raise InTrashError(
                    "what it was made from is in the trash, too",
                    field="id",
                    value=id,
                    allowed="what it was made from is restored first",
                )
        return Entry(**row._mapping)

    def remove(self, id: str) -> None:
        """Remove a thing in the trash for good; `InUseError` if another one there was made from it."""
        removal = THINGS.delete().where(THINGS.c.id == id, self._restorable())
        try:
            with self._connect() as connection:
                row = connection.execute(removal.returning(THINGS.c.arrays_hash)).first()
        except IntegrityError:
            raise InUseError(
                f"{id!r} is what something else in the trash was made from: remove that first", value=id
            ) from None
        if row is None:
            raise self._absence(id)
        if row.arrays_hash:
            self._files.remove(id, row.arrays_hash)

    def _restorable(self) -> sa.ColumnElement[bool]:
        return _is_restorable() & manageable(THINGS.c.owner, self._viewer)

    def _absence(self, id: str) -> NotFoundError:
        return NotFoundError(f"there is no {id!r} in the trash", field="id", value=id)


def _discarded(row: dict[str, Any]) -> Discarded:
    removed = row.pop("removed")
    return Discarded(Entry(**row), removed, _until(removed))


def empty_trash(engine: sa.Engine, files: ArrayFiles, condition: sa.ColumnElement[bool]) -> int:
    """Return the number of things in the trash that were removed for good.

    What others were made from goes after these, and stays while one of them does.

    Parameters
    ----------
    condition
        On the row of a thing.
    """
    in_trash = THINGS.c.removed.is_not(None) & condition
    for column in users():
        in_trash &= ~sa.exists().where(column == THINGS.c.id)
    removal = THINGS.delete().where(in_trash).returning(THINGS.c.id, THINGS.c.arrays_hash)
    n = 0
    while True:
        with engine.begin() as connection:
            gone = connection.execute(removal).all()
        for id, digest in gone:
            if digest:
                files.remove(id, digest)
        if not gone:
            return n
        n += len(gone)
