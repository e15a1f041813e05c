"""Measurements of assignments, as the store knows them."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager

import sqlalchemy as sa

from modallab.assignments.terms import AssignmentTerms
from modallab.store.base import Trial
from modallab.store.plain import from_plain
from modallab.store.tables import ASSIGNMENTS, TRIALS

Connect = Callable[[], AbstractContextManager[sa.Connection]]


class SqlTrials:
    """Which measurements belong to which assignment."""

    def __init__(self, connect: Connect) -> None:
        self._connect = connect

    def fulfil(self, trial: Trial, measurement_id: str) -> None:
        """Enter the measurement of a trial."""
        condition = (TRIALS.c.assignment_id == trial.assignment_id) & (TRIALS.c.student == trial.student)
        change = TRIALS.update().where(condition, TRIALS.c.number == trial.number)
        with self._connect() as connection:
            connection.execute(change.values(measurement_id=measurement_id))

    def assignments_of(self, measurement_ids: Sequence[str]) -> dict[str, AssignmentTerms]:
        """Return the assignments of those measurements that belong to one."""
        return self._of(TRIALS.c.measurement_id.in_(measurement_ids))

    def of_class(self, class_id: str) -> dict[str, AssignmentTerms]:
        """Return the assignments of all measurements of a class by the measurements' ids."""
        return self._of((ASSIGNMENTS.c.class_id == class_id) & TRIALS.c.measurement_id.is_not(None))

    def _of(self, condition: sa.ColumnElement[bool]) -> dict[str, AssignmentTerms]:
        query = (
            sa.select(TRIALS.c.measurement_id, ASSIGNMENTS.c.body)
            .join(ASSIGNMENTS, ASSIGNMENTS.c.id == TRIALS.c.assignment_id)
            .where(condition)
        )
        with self._connect() as connection:
            return {id: from_plain(AssignmentTerms, body, {}) for id, body in connection.execute(query)}
