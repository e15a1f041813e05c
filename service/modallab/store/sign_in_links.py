"""Links: each signs the holder of a key in once, without the key."""

import secrets
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import sqlalchemy as sa

from modallab.core.errors import InvalidInputError
from modallab.store.base import UnauthorisedError
from modallab.store.keys import Key, digest, key_of, now, written
from modallab.store.tables import KEYS, SIGN_IN_LINKS

VALID = timedelta(days=7)  # until the next lesson
PAGE = "/#once="  # behind "#" stands what a browser sends to no server
_SECRET_BYTES = 32


@dataclass(frozen=True)
class Link:
    """A link that signs in once."""

    link: str
    """Address on the service, told this once; the secret in it is behind `#`, where browsers keep it."""
    key_id: str
    """Id of the key whose holder it signs in."""
    expires: str
    """ISO 8601, UTC, first moment at which it does not count; it ends with its use, too."""


class LinkBook:
    """Links in the store's database."""

    def __init__(self, engine: sa.Engine) -> None:
        self._engine = engine

    def create(self, key: Key) -> Link:
        """Return a new link of a key's holder.

        Raises
        ------
        InvalidInputError
            If the key does not count any more.
        """
        try:
            key.check()
        except UnauthorisedError as error:
            raise InvalidInputError(str(error), field="id", value=key.id, allowed="a valid key") from None
        secret, expires = secrets.token_urlsafe(_SECRET_BYTES), written(datetime.now(UTC) + VALID)
        with self._engine.begin() as connection:
            connection.execute(SIGN_IN_LINKS.delete().where(SIGN_IN_LINKS.c.expires <= now()))
            connection.execute(
                SIGN_IN_LINKS.insert().values(digest=digest(secret), key_id=key.id, expires=expires)
            )
        return Link(PAGE + secret, key.id, expires)

    def used(self, secret: str) -> Key:
        """Return the key of a link, which does not count afterwards.

        Raises
        ------
        UnauthorisedError
            If there is no such link, or its key does not count any more.
        """
        condition = (SIGN_IN_LINKS.c.digest == digest(secret)) & (SIGN_IN_LINKS.c.expires > now())
        taken = (
            SIGN_IN_LINKS.delete().where(condition).returning(SIGN_IN_LINKS.c.key_id)
        )  # of two at once, one gets it
        columns = [column for column in KEYS.c if column.name != "digest"]
        with self._engine.begin() as connection:
            key_id = connection.execute(taken).scalar()
            row = connection.execute(sa.select(*columns).where(KEYS.c.id == key_id)).first()
        if row is None:
            raise UnauthorisedError(
                "this link has been used, or is too old: ask for another, or sign in with the key"
            )
        key = key_of(row)
        key.check()
        return key
