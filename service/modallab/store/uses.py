"""Which stored things are in use: what keeps one from being removed."""

from collections.abc import Collection

import sqlalchemy as sa

from modallab.store.tables import METADATA, THINGS


def users() -> list[sa.Column[str]]:
    """Return the columns that name a thing which is in use: what is not removed with the thing itself."""
    return [key.parent for key in _keys() if key.ondelete != "CASCADE"]


def _keys() -> list[sa.ForeignKey]:
    keys = [key for table in METADATA.tables.values() for key in table.foreign_keys]
    return [key for key in keys if key.column is THINGS.c.id]


def is_used(id: str) -> sa.ColumnElement[bool]:
    """Return the condition under which a thing is in use by what is not in the trash."""
    whole = {key.parent.table: key.parent for key in _keys() if key.ondelete == "CASCADE"}
    conditions = []
    for user in users():
        use = sa.select(user).where(user == id)
        if user.table in whole:
            maker = THINGS.alias()
            use = use.join(maker, maker.c.id == whole[user.table]).where(maker.c.removed.is_(None))
        conditions.append(use.exists())
    return sa.or_(*conditions)


def lock_untrashed(connection: sa.Connection, ids: Collection[str]) -> bool:
    """Lock things until the transaction ends, and return whether none of them is in the trash.

    A thing that goes to the trash at this moment is waited for.
    """
    query = sa.select(THINGS.c.id).where(THINGS.c.id.in_(ids), THINGS.c.removed.is_(None))
    return set(connection.execute(query.with_for_update(read=True)).scalars()) == set(ids)
