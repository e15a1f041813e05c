"""API keys: a table of their SHA-256, from which none of them can be told.

A key is `modallab_<id>_<secret>` with a secret of 256 random bits. Guessing is out of question, so that a
plain hash is as good as a slow one. The id finds the row, the hash is compared in constant time.
"""

import hmac
import re
import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import StrEnum
from hashlib import sha256
from typing import Any

import sqlalchemy as sa

from modallab.core.errors import InvalidInputError, NotFoundError, bounds
from modallab.store.base import UnauthorisedError
from modallab.store.rows import new_id
from modallab.store.tables import KEYS, SESSIONS, SIGN_IN_LINKS
from modallab.store.viewer import Viewer, Visibility, manageable

_COLUMNS = [KEYS.c[name] for name in ("id", "name", "role", "class_id", "created", "expires", "revoked")]
_SECRET_BYTES = 32
_LONGEST_NAME = 100
_FORM = re.compile(r"modallab_([0-9a-f]{24})_[A-Za-z0-9_-]{43}")


class Role(StrEnum):
    """What the holder of a key may do."""

    ADMIN = "admin"
    INSTRUCTOR = "instructor"
    STUDENT = "student"
    SERVICE = "service"


_VISIBILITY = {
    Role.ADMIN: Visibility.EVERYTHING,
    Role.INSTRUCTOR: Visibility.CLASSES,
    Role.STUDENT: Visibility.OWN,
    Role.SERVICE: Visibility.OWN,
}


@dataclass(frozen=True)
class Key:
    """An API key, without its secret."""

    id: str
    """Id of the key, and owner of what is made with it."""
    name: str
    """Name of the person or program that holds it."""
    role: Role
    """What the holder may do."""
    class_id: str | None
    """Class that the holder is a member of; None: of no class."""
    created: str
    """ISO 8601, UTC."""
    expires: str | None
    """ISO 8601, UTC, first moment at which it does not count; None: it never expires."""
    revoked: str | None
    """ISO 8601, UTC; None: it has not been revoked."""

    @property
    def viewer(self) -> Viewer:
        """Its holder, as the store sees him."""
        return Viewer(self.id, _VISIBILITY[self.role], self.class_id)

    def check(self) -> None:
        """Raise `UnauthorisedError` if the key does not count any more."""
        if self.revoked is not None:
            raise UnauthorisedError("this key has been revoked")
        if self.expires is not None and self.expires <= now():
            raise UnauthorisedError(f"this key expired at {self.expires}")


@dataclass(frozen=True)
class NewKey:
    """A key and its text, which is told once and stored nowhere."""

    key: Key
    text: str


def now() -> str:
    """Return the present time, ISO 8601, UTC; later times sort behind."""
    return written(datetime.now(UTC))


def written(time: datetime) -> str:
    """Return a time as the tables have it."""
    return time.astimezone(UTC).isoformat(timespec="microseconds")


def digest(text: str) -> str:
    """Return the SHA-256 of a secret."""
    return sha256(text.encode()).hexdigest()


def key_of(row: sa.Row[Any]) -> Key:
    """Return the key of a row."""
    return Key(**{**row._mapping, "role": Role(row.role)})


class KeyBook:
    """Keys in the store's database."""

    def __init__(self, engine: sa.Engine) -> None:
        self._engine = engine
        self._known_to_exist = False

    def exists(self) -> bool:
        """Return whether there is a key; where there is none, everybody may do everything."""
        if not self._known_to_exist:  # they are never removed
            with self._engine.begin() as connection:
                self._known_to_exist = connection.execute(sa.select(KEYS.c.id).limit(1)).first() is not None
        return self._known_to_exist

    def create(self, name: str, role: Role, *, expires: datetime | None = None) -> NewKey:
        """Return a new key.

        Raises
        ------
        InvalidInputError
            If it is the first key and not an administrator's: nobody could make another.
        """
        if role is not Role.ADMIN and not self.exists():
            raise InvalidInputError(
                "the first key is an administrator's", field="role", value=role, allowed=[Role.ADMIN.value]
            )
        until = None if expires is None else written(expires)
        return self.create_several([name], role, expires=until)[0]

    def create_several(
        self,
        names: Sequence[str],
        role: Role,
        *,
        expires: str | None = None,
        class_id: str | None = None,
    ) -> list[NewKey]:
        """Return new keys of one role, by the names of their holders: all are stored, or none."""
        for name in names:
            if not 1 <= len(name) <= _LONGEST_NAME:
                allowed = bounds(1, _LONGEST_NAME, unit="characters")
                raise InvalidInputError("a key names its holder", field="name", value=name, allowed=allowed)
        keys = [Key(new_id(), name, role, class_id, now(), expires, None) for name in names]
        new_keys = [NewKey(key, _text(key.id)) for key in keys]
        with self._engine.begin() as connection:
            connection.execute(
                KEYS.insert(), [vars(new.key) | {"digest": digest(new.text)} for new in new_keys]
            )
        return new_keys

    def verified(self, text: str) -> Key:
        """Return the key of a text that was sent.

        Raises
        ------
        UnauthorisedError
            If there is none, or it does not count any more.
        """
        form = _FORM.fullmatch(text)
        query = sa.select(*_COLUMNS, KEYS.c.digest).where(KEYS.c.id == (form[1] if form else ""))
        with self._engine.begin() as connection:
            row = connection.execute(query).first()
        if row is None or not hmac.compare_digest(row.digest, digest(text)):
            raise UnauthorisedError("this key is not known")
        key = Key(
            **{column.name: row._mapping[column.name] for column in _COLUMNS} | {"role": Role(row.role)}
        )
        key.check()
        return key

    def get(self, id: str, *, viewer: Viewer) -> Key:
        """Return a key, if it is there for the viewer."""
        query = sa.select(*_COLUMNS).where(KEYS.c.id == id, manageable(KEYS.c.id, viewer))
        with self._engine.begin() as connection:
            row = connection.execute(query).first()
        if row is None:
            raise NotFoundError(f"there is no key {id!r}", field="id", value=id)
        return key_of(row)

    def list(
        self,
        *,
        viewer: Viewer,
        class_id: str | None = None,
        limit: int | None = None,
        cursor: str | None = None,
    ) -> list[Key]:
        """Return the newest keys that are there for the viewer, those of a class if it is named."""
        query = sa.select(*_COLUMNS).where(manageable(KEYS.c.id, viewer))
        if class_id is not None:
            query = query.where(KEYS.c.class_id == class_id)
        if cursor is not None:
            last = self.get(cursor, viewer=viewer)
            age = sa.tuple_(KEYS.c.created, KEYS.c.id)
            query = query.where(age < sa.tuple_(sa.literal(last.created), sa.literal(last.id)))
        query = query.order_by(KEYS.c.created.desc(), KEYS.c.id.desc()).limit(limit)
        with self._engine.begin() as connection:
            return [key_of(row) for row in connection.execute(query)]

    def revoke(self, id: str, *, viewer: Viewer) -> None:
        """Revoke a key; nothing happens to one that has been revoked."""
        key = self.get(id, viewer=viewer)
        with self._engine.begin() as connection:
            connection.execute(
                KEYS.update().where(KEYS.c.id == key.id, KEYS.c.revoked.is_(None)).values(revoked=now())
            )

    def rotate(self, id: str, *, viewer: Viewer) -> NewKey:
        """Return a key with a new secret; the former one ends, with its sessions and links.

        Raises
        ------
        InvalidInputError
            If the key has been revoked.
        """
        key = self.get(id, viewer=viewer)
        if key.revoked is not None:
            raise InvalidInputError("this key has been revoked", field="id", value=id, allowed="a valid key")
        new = NewKey(key, _text(id))
        with self._engine.begin() as connection:
            connection.execute(KEYS.update().where(KEYS.c.id == id).values(digest=digest(new.text)))
            for table in (SESSIONS, SIGN_IN_LINKS):
                connection.execute(table.delete().where(table.c.key_id == id))
        return new


def _text(id: str) -> str:
    return f"modallab_{id}_{secrets.token_urlsafe(_SECRET_BYTES)}"
