"""Replies of assignments: what a student may see of one, and everything."""

from typing import Any

from pydantic import Field

from modallab.api.access import Caller
from modallab.api.replies import reply, reply_of
from modallab.api.wire import Reply, place_out
from modallab.assignments.hidden import HiddenEffect
from modallab.assignments.marking import Marks, Rubric
from modallab.core.place import EffectSpec
from modallab.store.assignments import MarkedAnswer, StoredAssignment
from modallab.store.keys import Key, now
from modallab.store.viewer import Visibility

Json = dict[str, Any]


def _is_none(value: object) -> bool:
    return value is None


RubricReply: Any = reply(
    Rubric,
    "Rubric",
    leave_out=("expected",),
    names=(list[str], "Names of the coefficients that are asked for."),
)


class Assignment(Reply):
    """An assignment, as the caller may see it."""

    id: str
    """id of the assignment"""
    class_id: str
    """id of the class"""
    owner: str
    """id of the instructor's key"""
    created: str
    """time of creation, ISO 8601, UTC"""
    title: str
    """title of the assignment"""
    structure_id: str
    """id of the analytical model, without hidden effects"""
    rig: Json
    """body of the rig as it stands where a student chooses nothing"""
    choices: dict[str, Json]
    """fields that a student may choose, with `between` or `one_of`"""
    quota: int
    """1, measurements of each student"""
    submissions: int
    """1, answers of each student"""
    diagnosis: str
    """whether students may diagnose the measurements: `off`, `on` or `after_deadline`"""
    deadline: str | None
    """ISO 8601, UTC, end of measurements and answers; null: none"""
    reveal: str | None
    """ISO 8601, UTC, time from which students see their hidden effects; null: never"""
    rubric: RubricReply
    """points of an answer"""
    measurements: list[str | None]
    """ids of the caller's measurements, oldest first; null: not finished, or failed"""
    submission: "Submission | None"
    """the caller's last answer; null: none yet"""
    revealed: list[Json] | None = Field(default=None, exclude_if=_is_none)
    """the caller's hidden effects; left out before the time `reveal`"""
    hidden: list[Json] | None = Field(default=None, exclude_if=_is_none)
    """hidden effects or their templates; left out for students"""
    expected: dict[str, Json] | None = Field(default=None, exclude_if=_is_none)
    """right coefficients by name; left out for students"""


class Submission(Reply):
    """An answer with its marks."""

    number: int
    """1, number of the answer, from 1 on"""
    created: str
    """time of the answer, ISO 8601, UTC"""
    effects: list[Json]
    """effects as they were sent"""
    coefficients: dict[str, float]
    """coefficients as they were sent"""
    words: str
    """words for the instructor"""
    marks: reply_of(Marks)  # type: ignore[valid-type]
    """points, with reasons"""


class StudentMarks(Reply):
    """A student's row of the class table."""

    student: str
    """id of the student's key"""
    name: str
    """name of the student"""
    measurements: int
    """1, measurements made or under way"""
    submission: Submission | None
    """the last answer, with its marks; null: none yet"""


class Assignments(Reply):
    """All assignments."""

    items: list[Assignment]
    """Assignments, newest first."""


class ClassMarks(Reply):
    """Marks of a class."""

    items: list[StudentMarks]
    """One row a student."""


def assignment_reply(
    stored: StoredAssignment, caller: Caller, measurements: list[str | None], last: MarkedAnswer | None
) -> Assignment:
    """Return an assignment; what is hidden is told to its instructor and to administrators alone."""
    assignment = stored.assignment
    rubric = vars(assignment.rubric)
    reply = {
        **{name: value for name, value in vars(stored).items() if name not in ("secret", "assignment")},
        **{name: value for name, value in vars(assignment).items() if name not in ("hidden", "rubric")},
        "choices": {path: limits_out(vars(choice)) for path, choice in assignment.choices.items()},
        "rubric": rubric | {"names": sorted(assignment.rubric.expected)},
        "measurements": measurements,
        "submission": None if last is None else submission_reply(last),
    }
    if caller.viewer.visibility is not Visibility.OWN:
        reply["hidden"] = [_template(effect) for effect in assignment.hidden]
        reply["expected"] = {name: dict(vars(right)) for name, right in assignment.rubric.expected.items()}
    if assignment.is_revealed(now()):
        reply["revealed"] = [_effect(spec) for spec in stored.hidden_from(caller.viewer.owner)]
    return Assignment.model_validate(reply)


def limits_out(choice: Json) -> Json:
    """Return the limits of a choice as the contract writes them."""
    if choice["lower"] is None:
        return {"one_of": list(choice["values"])}
    return {"between": [choice["lower"], choice["upper"]]}


def submission_reply(submission: MarkedAnswer) -> Submission:
    """Return the reply of an answer."""
    answer = submission.answer
    return Submission.model_validate(
        {
            "number": submission.number,
            "created": submission.created,
            "effects": [_effect(spec) for spec in answer.effects],
            "coefficients": dict(answer.coefficients),
            "words": answer.words,
            "marks": submission.marks,
        }
    )


def student_marks(key: Key, measurements: list[str | None], last: MarkedAnswer | None) -> StudentMarks:
    """Return a student's row of the class table."""
    return StudentMarks(
        student=key.id,
        name=key.name,
        measurements=len(measurements),
        submission=None if last is None else submission_reply(last),
    )


MARK_COLUMNS = (
    "name",
    "student",
    "measurements",
    "submitted",
    "kind",
    "place",
    "size",
    "coefficients",
    "points_for_words",
    "points",
    "maximum",
    "words",
)


def mark_row(row: StudentMarks) -> Json:
    """Return a student's row of the table in CSV."""
    cells: Json = {"name": row.name, "student": row.student, "measurements": row.measurements}
    if row.submission is None:
        return cells
    marks: Any = row.submission.marks
    points = {
        "points_for_words" if mark.criterion == "words" else mark.criterion: mark.points
        for mark in marks.marks
        if mark.points is not None
    }
    total = {"points": marks.points, "maximum": marks.maximum}
    return (
        cells
        | points
        | total
        | {"submitted": row.submission.created, "words": _no_formula(row.submission.words)}
    )


def _no_formula(words: str) -> str:
    """Return words that a spreadsheet shows and does not compute."""
    return f"'{words}" if words.startswith(("=", "+", "-", "@", "\t", "\r")) else words


def _template(effect: HiddenEffect) -> Json:
    places = [place_out(place) for place in effect.places]
    parameters = {
        name: lower if lower == upper else {"between": [lower, upper]}
        for name, (lower, upper) in effect.intervals.items()
    }
    at = places[0] if len(places) == 1 else {"one_of": places}
    return {"kind": effect.kind, "at": at, "parameters": parameters}


def _effect(spec: EffectSpec) -> Json:
    return {"kind": spec.kind, "at": place_out(spec.at), "parameters": dict(spec.parameters)}
