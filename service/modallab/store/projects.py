"""Projects in an SQL store, their objects in an order in which they can be made again."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from dataclasses import fields
from typing import Any

import sqlalchemy as sa

from modallab.core.errors import InvalidInputError
from modallab.store.arrays import ArrayFiles
from modallab.store.base import Entry, MissingFileError
from modallab.store.exported import ProjectContents, StoredParts
from modallab.store.tables import THINGS, TRIALS

Connect = Callable[[], AbstractContextManager[sa.Connection]]
_ENTRY = [THINGS.c[field.name] for field in fields(Entry)]


class SqlProjects:
    """Objects of owners as they lie in the store; truths are not among them."""

    def __init__(self, connect: Connect, files: ArrayFiles) -> None:
        self._connect, self._files = connect, files

    def contents(self, *, owner: str, label: str | None = None) -> ProjectContents:
        """Return the objects of an owner that an export writes, each after its origins.

        Objects made from those of others, or from a measurement of an assignment, are left out.

        Parameters
        ----------
        label
            Objects with this label and their origins; None: all objects.
        """
        query = sa.select(*_ENTRY).where(THINGS.c.owner == owner, THINGS.c.removed.is_(None))
        sealed_query = sa.select(TRIALS.c.measurement_id).where(TRIALS.c.student == owner)
        with self._connect() as connection:
            rows = connection.execute(query.order_by(THINGS.c.created, THINGS.c.id)).all()
            sealed = set(connection.execute(sealed_query).scalars())
        owned = {row.id: Entry(**row._mapping) for row in rows}
        chosen = [entry for entry in owned.values() if label is None or label in entry.labels]
        wanted = _with_origins(chosen, owned)
        exported = _in_order([entry for id, entry in owned.items() if id in wanted and id not in sealed])
        ids = {entry.id for entry in exported}
        return ProjectContents(tuple(exported), tuple(id for id in owned if id in wanted - ids))

    def parts(self, id: str) -> StoredParts:
        """Return a thing as it lies in the store."""
        row = self._row(id)
        try:
            arrays = self._files.get(id, row.arrays_hash) if row.arrays_hash else b""
        except MissingFileError:
            self._row(id)  # another may just have removed the thing
            raise
        return StoredParts(row.body, row.request, arrays)

    def _row(self, id: str) -> sa.Row[Any]:
        columns: list[sa.Column[Any]] = [THINGS.c.body, THINGS.c.request, THINGS.c.arrays_hash]
        query = sa.select(*columns).where(THINGS.c.id == id, THINGS.c.removed.is_(None))
        with self._connect() as connection:
            row = connection.execute(query).first()
        if row is None:
            raise InvalidInputError(f"{id!r} was removed while it was written: try again", value=id)
        return row


def _with_origins(chosen: Iterable[Entry], owned: Mapping[str, Entry]) -> set[str]:
    """Return the ids of entries and of all that they were made from, as far as it is the owner's."""
    waiting, ids = list(chosen), set[str]()
    while waiting:
        entry = waiting.pop()
        if entry.id not in ids:
            ids.add(entry.id)
            waiting += [owned[origin] for origin in entry.inputs.values() if origin in owned]
    return ids


def _in_order(entries: Iterable[Entry]) -> list[Entry]:
    """Return the entries each after those that it was made from, without those that lack one of these."""
    ordered, ids, waiting = list[Entry](), set[str](), list(entries)
    while True:
        ready = [entry for entry in waiting if ids.issuperset(entry.inputs.values())]
        if not ready:
            return ordered
        ordered += ready
        ids |= {entry.id for entry in ready}
        waiting = [entry for entry in waiting if entry.id not in ids]
