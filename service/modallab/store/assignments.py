"""Assignments: their rows, the trials of students and their answers."""

import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError

from modallab.assignments.drawing import Lot
from modallab.assignments.hidden import drawn_for
from modallab.assignments.marking import Answer, Marks, with_points_for_words
from modallab.assignments.terms import AssignmentError, AssignmentTerms
from modallab.core.errors import NotFoundError
from modallab.core.place import EffectSpec
from modallab.store.keys import now
from modallab.store.plain import from_plain, to_plain
from modallab.store.rows import insert_once, new_id
from modallab.store.tables import ASSIGNMENTS, SHARES, SUBMISSIONS, TRIALS
from modallab.store.uses import lock_untrashed
from modallab.store.viewer import Viewer, manageable

_COLUMNS = [
    ASSIGNMENTS.c[name] for name in ("id", "class_id", "owner", "structure_id", "created", "secret", "body")
]
_MOST_ATTEMPTS = 20  # of entering a row whose number others take at the same moment


@dataclass(frozen=True)
class StoredAssignment:
    """An assignment as it is kept."""

    id: str
    class_id: str
    owner: str
    """Id of the instructor's key."""
    structure_id: str
    """Structure that students see: the analytical model, without hidden effects."""
    created: str
    secret: str
    """Origin of all draws and seeds; no reply tells it."""
    assignment: AssignmentTerms

    def hidden_from(self, student: str) -> tuple[EffectSpec, ...]:
        """Return the effects of one student, by the id of the key."""
        return drawn_for(self.assignment.hidden, self.secret, student)

    def seed(self, student: str, number: int) -> int:
        """Return the seed of a student's measurement: another one for each, whatever was asked for."""
        return Lot(self.secret, f"seed/{self.id}/{student}").integer(number)


@dataclass(frozen=True)
class MarkedAnswer:
    """An answer with its marks."""

    student: str
    """Id of the student's key."""
    number: int
    """1, number of the answer, from 1 on."""
    created: str
    """ISO 8601, UTC."""
    answer: Answer
    """What the student says."""
    marks: Marks
    """Its points."""


class AssignmentBook:
    """Assignments in the store's database."""

    def __init__(self, engine: sa.Engine) -> None:
        self._engine = engine

    def create(
        self, assignment: AssignmentTerms, *, class_id: str, owner: str, structure_id: str
    ) -> StoredAssignment:
        """Return a new assignment; its structure is shared with the class."""
        row = {
            "id": new_id(),
            "class_id": class_id,
            "owner": owner,
            "structure_id": structure_id,
            "created": now(),
            "secret": secrets.token_hex(32),
            "body": to_plain(assignment)[0],
        }
        with self._engine.begin() as connection:
            connection.execute(ASSIGNMENTS.insert().values(**row))
            insert_once(connection, SHARES, {"class_id": class_id, "thing_id": structure_id})
            if not lock_untrashed(connection, [structure_id]):
                raise NotFoundError(
                    "the structure is no longer stored", field="structure", value=structure_id
                )
        return _stored(row)

    def get(self, id: str, *, viewer: Viewer) -> StoredAssignment:
        """Return an assignment, if it is there for the viewer."""
        query = sa.select(*_COLUMNS).where(ASSIGNMENTS.c.id == id, _readable(viewer))
        with self._engine.begin() as connection:
            row = connection.execute(query).first()
        if row is None:
            raise NotFoundError(f"there is no assignment {id!r}", field="id", value=id)
        return _stored(row._asdict())

    def all(self, *, viewer: Viewer) -> list[StoredAssignment]:
        """Return all assignments that are there for the viewer, newest first."""
        query = sa.select(*_COLUMNS).where(_readable(viewer))
        query = query.order_by(ASSIGNMENTS.c.created.desc(), ASSIGNMENTS.c.id)
        with self._engine.begin() as connection:
            return [_stored(row._asdict()) for row in connection.execute(query)]

    def close(self, id: str, *, viewer: Viewer) -> None:
        """List an assignment no more; its measurements stay, sealed as they are."""
        self.get(id, viewer=viewer)
        with self._engine.begin() as connection:
            connection.execute(ASSIGNMENTS.update().where(ASSIGNMENTS.c.id == id).values(closed=now()))

    def take_trial(self, stored: StoredAssignment, student: str, request_key: str | None) -> tuple[int, bool]:
        """Return the number of a student's next measurement, and whether it is new: not of the same request.

        Raises
        ------
        AssignmentError
            If the student has had all.
        """
        same = (TRIALS.c.assignment_id == stored.id) & (TRIALS.c.student == student)
        if request_key is not None:
            repeated = sa.select(TRIALS.c.number).where(same, TRIALS.c.request_key == request_key)
            with self._engine.begin() as connection:
                number = connection.execute(repeated).scalar()
            if number is not None:
                return int(number), False
        quota = stored.assignment.quota
        row = {"assignment_id": stored.id, "student": student, "request_key": request_key}
        return self._numbered(TRIALS, same, row, quota, "measurements are used up", "quota"), True

    def give_back(self, stored: StoredAssignment, student: str, number: int) -> None:
        """Forget a measurement that was not started."""
        condition = (TRIALS.c.assignment_id == stored.id) & (TRIALS.c.student == student)
        with self._engine.begin() as connection:
            connection.execute(TRIALS.delete().where(condition, TRIALS.c.number == number))

    def submit(self, stored: StoredAssignment, student: str, answer: Answer, marks: Marks) -> MarkedAnswer:
        """Return a student's answer after entering it.

        Raises
        ------
        AssignmentError
            If the student has answered as often as one may.
        """
        created = now()
        same = (SUBMISSIONS.c.assignment_id == stored.id) & (SUBMISSIONS.c.student == student)
        row = {
            "assignment_id": stored.id,
            "student": student,
            "created": created,
            "answer": to_plain(answer)[0],
            "marks": to_plain(marks)[0],
        }
        most = stored.assignment.submissions
        number = self._numbered(SUBMISSIONS, same, row, most, "answers are given", "submissions")
        return MarkedAnswer(student, number, created, answer, marks)

    def grade_words(
        self, stored: StoredAssignment, student: str, points: float, comment: str
    ) -> MarkedAnswer:
        """Return the last answer of a student with the instructor's points for its words.

        Raises
        ------
        NotFoundError
            If the student has not answered.
        InvalidInputError
            If the rubric gives no points for words, or fewer.
        """
        answer = self.submissions(stored, [student]).get(student)
        if answer is None:
            raise NotFoundError(
                f"{student!r} has not answered this assignment", field="student", value=student
            )
        marks = with_points_for_words(answer.marks, points, comment)
        same = (SUBMISSIONS.c.assignment_id == stored.id) & (SUBMISSIONS.c.student == student)
        change = SUBMISSIONS.update().where(same, SUBMISSIONS.c.number == answer.number)
        with self._engine.begin() as connection:
            connection.execute(change.values(marks=to_plain(marks)[0]))
        return replace(answer, marks=marks)

    def _numbered(
        self,
        table: sa.Table,
        same: sa.ColumnElement[bool],
        row: Mapping[str, object],
        most: int,
        words: str,
        field: str,
    ) -> int:
        """Return the number of a row after entering it behind those of the same student."""
        for _ in range(_MOST_ATTEMPTS):
            try:
                with self._engine.begin() as connection:
                    last = connection.execute(sa.select(sa.func.max(table.c.number)).where(same)).scalar()
                    number = (last or 0) + 1
                    if number > most:
                        raise AssignmentError(f"all {words}", field=field, value=number, allowed=most)
                    connection.execute(table.insert().values(**row, number=number))
                return number
            except IntegrityError:  # the number was taken this very moment
                continue
        raise AssignmentError("too many requests at the same moment", field=field, allowed="one at a time")

    def measurements(self, stored: StoredAssignment, students: Sequence[str]) -> dict[str, list[str | None]]:
        """Return the measurements of students, oldest first; None for one that is not made, or not yet."""
        query = sa.select(TRIALS.c.student, TRIALS.c.measurement_id).order_by(TRIALS.c.number)
        query = query.where(TRIALS.c.assignment_id == stored.id, TRIALS.c.student.in_(students))
        found: dict[str, list[str | None]] = {student: [] for student in students}
        with self._engine.begin() as connection:
            for student, measurement_id in connection.execute(query):
                found[student].append(measurement_id)
        return found

    def submissions(self, stored: StoredAssignment, students: Sequence[str]) -> dict[str, MarkedAnswer]:
        """Return the last answer of each student who gave one."""
        query = sa.select(SUBMISSIONS).order_by(SUBMISSIONS.c.number)
        query = query.where(SUBMISSIONS.c.assignment_id == stored.id, SUBMISSIONS.c.student.in_(students))
        with self._engine.begin() as connection:
            return {row.student: _submission(row) for row in connection.execute(query)}


def _readable(viewer: Viewer) -> sa.ColumnElement[bool]:
    condition = manageable(ASSIGNMENTS.c.owner, viewer)
    if viewer.class_id is not None:
        condition = condition | (ASSIGNMENTS.c.class_id == viewer.class_id)
    return condition & ASSIGNMENTS.c.closed.is_(None)


def _stored(row: Mapping[str, object]) -> StoredAssignment:
    values = {name: value for name, value in row.items() if name != "body"}
    return StoredAssignment(**values, assignment=from_plain(AssignmentTerms, row["body"], {}))  # type: ignore[arg-type]


def _submission(row: sa.Row[tuple[object, ...]]) -> MarkedAnswer:
    answer, marks = from_plain(Answer, row.answer, {}), from_plain(Marks, row.marks, {})
    return MarkedAnswer(row.student, row.number, row.created, answer, marks)
