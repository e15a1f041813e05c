"""Truths of measurements, in a separate table."""

from collections.abc import Callable
from contextlib import AbstractContextManager

import sqlalchemy as sa

from modallab.core.errors import NotFoundError
from modallab.store.base import Truth
from modallab.store.plain import from_plain, to_plain
from modallab.store.rows import insert_once
from modallab.store.tables import TRUTHS
from modallab.store.uses import lock_untrashed

Connect = Callable[[], AbstractContextManager[sa.Connection]]


class SqlTruths:
    """Truths of measurements."""

    def __init__(self, connect: Connect) -> None:
        self._connect = connect

    def add(self, truth: Truth, *, measurement_id: str, owner: str) -> None:
        """Store how a measurement was made, once."""
        row = {"measurement_id": measurement_id, "structure_id": truth.structure_id, "owner": owner}
        with self._connect() as connection:
            insert_once(connection, TRUTHS, row | {"body": to_plain(truth)[0]})
            if not lock_untrashed(connection, [truth.structure_id]):
                raise NotFoundError("the structure that was tested is no longer stored", field="structure_id")

    def get(self, measurement_id: str, *, owner: str) -> Truth:
        """Return the truth of a measurement to its owner."""
        condition = (TRUTHS.c.measurement_id == measurement_id) & (TRUTHS.c.owner == owner)
        with self._connect() as connection:
            row = connection.execute(sa.select(TRUTHS.c.body).where(condition)).first()
        if row is None:
            raise NotFoundError(
                f"how measurement {measurement_id!r} was made is not known", value=measurement_id
            )
        return from_plain(Truth, row.body, {})

    def holds(self, measurement_id: str) -> bool:
        """Tell whether it is known how a measurement was made."""
        query = sa.select(TRUTHS.c.measurement_id).where(TRUTHS.c.measurement_id == measurement_id)
        with self._connect() as connection:
            return connection.execute(query).first() is not None
