"""Quotas: what the holder of one key, and the members of one class, may have of what all share."""

from dataclasses import dataclass

import sqlalchemy as sa

from modallab.core.errors import ModalLabError
from modallab.store.arrays import ArrayFiles
from modallab.store.tables import KEYS, THINGS
from modallab.store.trash import empty_trash
from modallab.store.viewer import LOCAL


class StorageQuotaError(ModalLabError):
    """As much is stored for a key, or for a class, as may be."""

    code = "storage_quota"


@dataclass(frozen=True)
class Quotas:
    """Largest amounts; None: no limit. Whoever works without keys has none."""

    of_key: int | None = None
    """For one key."""
    of_class: int | None = None
    """For all keys of one class together."""

    def excess(
        self, connection: sa.Connection, owner: str, owners: sa.Column[str], amount: sa.Select[int]
    ) -> tuple[str, int] | None:
        """Return who has more than allowed, `key` or `class`, and the quota; None if nobody does.

        Parameters
        ----------
        owners
            Column of the owners of what is counted.
        amount
            Query of the amount of all owners.
        """
        if owner == LOCAL:
            return None
        own_class = sa.select(KEYS.c.class_id).where(KEYS.c.id == owner).scalar_subquery()
        members = owners.in_(sa.select(KEYS.c.id).where(KEYS.c.class_id == own_class))
        for name, quota, whose in (("key", self.of_key, owners == owner), ("class", self.of_class, members)):
            if quota is not None and connection.execute(amount.where(whose)).scalar_one() > quota:
                return name, quota
        return None


NO_QUOTAS = Quotas()


def check_storage(engine: sa.Engine, files: ArrayFiles, owner: str, quotas: Quotas) -> None:
    """Raise `StorageQuotaError` if more bytes are stored for an owner, or for the class, than may be.

    The owner's trash counts, and is emptied where it takes room that is needed.
    """
    excess = _excess_bytes(engine, owner, quotas)
    if excess is not None and empty_trash(engine, files, THINGS.c.owner == owner):
        excess = _excess_bytes(engine, owner, quotas)
    if excess is not None:
        name, quota = excess
        raise StorageQuotaError(
            f"as much is stored for this {name} as may be: remove something first", allowed=f"{quota} bytes"
        )


def _excess_bytes(engine: sa.Engine, owner: str, quotas: Quotas) -> tuple[str, int] | None:
    stored = sa.select(sa.func.coalesce(sa.func.sum(THINGS.c.size), 0))
    with engine.begin() as connection:
        return quotas.excess(connection, owner, THINGS.c.owner, stored)
