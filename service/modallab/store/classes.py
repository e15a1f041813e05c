"""Classes: students' keys, and what their instructor shares with them."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError

from modallab.core.errors import InvalidInputError, NotFoundError
from modallab.store.keys import KeyBook, NewKey, Role, now, written
from modallab.store.rows import insert_once, new_id
from modallab.store.tables import CLASSES, KEYS, SHARES, THINGS
from modallab.store.viewer import Viewer, manageable

_COLUMNS = [CLASSES.c[name] for name in ("id", "name", "owner", "created", "expires")]


@dataclass(frozen=True)
class Class:
    """A class of students."""

    id: str
    """Id of the class."""
    name: str
    """Name of the class."""
    owner: str
    """Id of the key of its instructor."""
    created: str
    """ISO 8601, UTC."""
    expires: str | None
    """ISO 8601, UTC, when the keys of its members expire; None: never."""


class ClassBook:
    """Classes in the store's database."""

    def __init__(self, engine: sa.Engine, keys: KeyBook) -> None:
        self._engine, self._keys = engine, keys

    def create(self, name: str, *, owner: str, expires: datetime | None = None) -> Class:
        """Return a new class without members."""
        until = None if expires is None else written(expires)
        new_class = Class(new_id(), name, owner, now(), until)
        with self._engine.begin() as connection:
            connection.execute(CLASSES.insert().values(**vars(new_class)))
        return new_class

    def get(self, id: str, *, viewer: Viewer) -> Class:
        """Return a class, if it is there for the viewer."""
        query = sa.select(*_COLUMNS).where(CLASSES.c.id == id, _open(viewer))
        with self._engine.begin() as connection:
            row = connection.execute(query).first()
        if row is None:
            raise NotFoundError(f"there is no class {id!r}", field="id", value=id)
        return Class(**row._mapping)

    def list(self, *, viewer: Viewer) -> list[Class]:
        """Return all classes that are there for the viewer, newest first."""
        query = sa.select(*_COLUMNS).where(_open(viewer)).order_by(CLASSES.c.created.desc(), CLASSES.c.id)
        with self._engine.begin() as connection:
            return [Class(**row._mapping) for row in connection.execute(query)]

    def add_members(self, id: str, names: Sequence[str], *, viewer: Viewer) -> Sequence[NewKey]:
        """Return a new student's key for each name.

        Raises
        ------
        InvalidInputError
            If a name occurs twice, or is a member's: a list that is sent twice makes no second keys.
        """
        entered = self.get(id, viewer=viewer)
        query = sa.select(KEYS.c.name).where(KEYS.c.class_id == id, KEYS.c.revoked.is_(None))
        with self._engine.begin() as connection:
            members = set(connection.execute(query).scalars())
        for name in names:
            if name in members:
                raise InvalidInputError(
                    "this name is in the class already", field="names", value=name, allowed="each name once"
                )
            members.add(name)
        return self._keys.create_several(names, Role.STUDENT, expires=entered.expires, class_id=id)

    def close(self, id: str, *, viewer: Viewer) -> None:
        """Revoke all keys of a class, and list it no more; what its members made stays."""
        self.get(id, viewer=viewer)
        with self._engine.begin() as connection:
            connection.execute(CLASSES.update().where(CLASSES.c.id == id).values(closed=now()))
            connection.execute(
                KEYS.update().where(KEYS.c.class_id == id, KEYS.c.revoked.is_(None)).values(revoked=now())
            )

    def share(self, id: str, thing_id: str, *, viewer: Viewer) -> None:
        """Let the members of a class read a stored thing; nothing happens if they may already.

        Raises
        ------
        NotFoundError
            If class or thing are not there for the viewer.
        """
        self.get(id, viewer=viewer)
        is_there = (THINGS.c.id == thing_id) & THINGS.c.removed.is_(None)
        query = sa.select(THINGS.c.id).where(is_there, manageable(THINGS.c.owner, viewer))
        try:
            with self._engine.begin() as connection:
                found = connection.execute(query).first() is not None
                if found:
                    insert_once(connection, SHARES, {"class_id": id, "thing_id": thing_id})
        except IntegrityError:  # removed this very moment
            found = False
        if not found:
            raise NotFoundError("nothing is stored under this id", field="resource_id", value=thing_id)

    def shares(self, id: str) -> Sequence[str]:
        """Return the ids of what is shared with a class, sorted."""
        query = sa.select(SHARES.c.thing_id).join(THINGS, THINGS.c.id == SHARES.c.thing_id)
        query = query.where(SHARES.c.class_id == id, THINGS.c.removed.is_(None)).order_by(SHARES.c.thing_id)
        with self._engine.begin() as connection:
            return connection.execute(query).scalars().all()

    def withdraw(self, id: str, thing_id: str, *, viewer: Viewer) -> None:
        """Share a thing with a class no more."""
        self.get(id, viewer=viewer)
        condition = (SHARES.c.class_id == id) & (SHARES.c.thing_id == thing_id)
        with self._engine.begin() as connection:
            removed = connection.execute(
                SHARES.delete().where(condition).returning(SHARES.c.thing_id)
            ).first()
        if removed is None:
            raise NotFoundError("this is not shared with the class", field="resource_id", value=thing_id)


def _open(viewer: Viewer) -> sa.ColumnElement[bool]:
    return manageable(CLASSES.c.owner, viewer) & CLASSES.c.closed.is_(None)
