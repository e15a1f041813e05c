"""Removal of what is old and nobody gave a name, a label or a comment."""

from collections.abc import Collection

import sqlalchemy as sa

from modallab.store.arrays import ArrayFiles
from modallab.store.tables import SHARES, THINGS
from modallab.store.uses import users


def remove_unnamed(engine: sa.Engine, files: ArrayFiles, before: str, keep: Collection[str]) -> int:
    """Return the number of things that were removed: what was made from others first, and then these.

    Parameters
    ----------
    before
        ISO 8601, UTC: what was stored later stays.
    keep
        Ids of things that stay.
    """
    n = 0
    while removed := _remove_unused(engine, before, keep):
        for id, digest in removed:
            if digest is not None:
                files.remove(id, digest)
        n += len(removed)
    return n


def _remove_unused(engine: sa.Engine, before: str, keep: Collection[str]) -> list[tuple[str, str | None]]:
    """Remove the unnamed things that nothing was made from; return their ids and digests of their arrays."""
    own_name = sa.func.substr(sa.func.coalesce(THINGS.c.body["name"].as_string(), ""), 1, 100)
    # A structure is stored with the name of its description, which nobody has given it.
    is_unnamed = (THINGS.c.name == "") | ((THINGS.c.kind == "structure") & (THINGS.c.name == own_name))
    without_words = (sa.cast(THINGS.c.labels, sa.Text) == "[]") & (THINGS.c.comment == "")
    condition = (THINGS.c.created < before) & is_unnamed & without_words & THINGS.c.id.not_in(list(keep))
    condition &= THINGS.c.removed.is_(None)
    for column in (*users(), SHARES.c.thing_id):
        condition &= ~sa.exists().where(column == THINGS.c.id)
    removal = THINGS.delete().where(condition).returning(THINGS.c.id, THINGS.c.arrays_hash)
    with engine.begin() as connection:
        return [(row.id, row.arrays_hash) for row in connection.execute(removal)]
