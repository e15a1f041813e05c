"""Sizes of stored things, told without reading them."""

from collections.abc import Sequence

import sqlalchemy as sa

from modallab.store.arrays import ArrayFiles
from modallab.store.tables import LINKS, THINGS


def weight_of(
    connection: sa.Connection, files: ArrayFiles, ids: Sequence[str], array_bytes: float, *, origins: bool
) -> float:
    """Return the bytes of things; ids without a thing weigh nothing.

    Parameters
    ----------
    array_bytes
        Bytes of arrays that count as one.
    origins
        Whether the things count that these were made from.
    """
    sources = sa.select(LINKS.c.target).where(LINKS.c.source.in_(ids))
    length = sa.func.length(sa.cast(THINGS.c.body, sa.Text))
    condition = THINGS.c.id.in_(ids) | THINGS.c.id.in_(sources) if origins else THINGS.c.id.in_(ids)
    query = sa.select(length, THINGS.c.id, THINGS.c.arrays_hash).where(condition)
    rows = connection.execute(query).all()
    arrays = sum(files.size(id, digest) for _, id, digest in rows if digest)
    return float(sum(text for text, _, _ in rows) + arrays / array_bytes)
