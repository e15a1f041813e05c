"""Sessions: a key exchanged for the cookie of a browser."""

import secrets
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import sqlalchemy as sa

from modallab.store.base import UnauthorisedError
from modallab.store.keys import Key, digest, key_of, now, written
from modallab.store.tables import KEYS, SESSIONS

LENGTH = timedelta(hours=12)  # a day's work; a key that expires earlier ends its sessions


@dataclass(frozen=True)
class Session:
    """A new session."""

    cookie: str
    key: Key


class SessionBook:
    """Sessions in the store's database."""

    def __init__(self, engine: sa.Engine) -> None:
        self._engine = engine

    def create(self, key: Key) -> Session:
        """Return a new session of a key's holder."""
        session = Session(secrets.token_urlsafe(32), key)
        row = {
            "digest": digest(session.cookie),
            "key_id": key.id,
            "expires": written(datetime.now(UTC) + LENGTH),
        }
        with self._engine.begin() as connection:
            connection.execute(SESSIONS.delete().where(SESSIONS.c.expires <= now()))
            connection.execute(SESSIONS.insert().values(**row))
        return session

    def key(self, cookie: str) -> Key:
        """Return the key of a session.

        Raises
        ------
        UnauthorisedError
            If there is no such session, or its key does not count any more.
        """
        condition = (SESSIONS.c.digest == digest(cookie)) & (SESSIONS.c.expires > now())
        columns = [column for column in KEYS.c if column.name != "digest"]
        query = sa.select(*columns).join(SESSIONS, SESSIONS.c.key_id == KEYS.c.id).where(condition)
        with self._engine.begin() as connection:
            row = connection.execute(query).first()
        if row is None:
            raise UnauthorisedError("the session has ended: sign in again")
        key = key_of(row)
        key.check()
        return key

    def end(self, cookie: str) -> None:
        """End a session; nothing happens if it has ended."""
        with self._engine.begin() as connection:
            connection.execute(SESSIONS.delete().where(SESSIONS.c.digest == digest(cookie)))
