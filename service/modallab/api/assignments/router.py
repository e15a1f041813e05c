"""Assignments: made by instructors, measured and answered by students."""

import json
from hashlib import sha256
from operator import attrgetter
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Request, status

from modallab.api.access import Caller, CallerDep, KeyDep, TeacherKeyDep
from modallab.api.assignments.replies import (
    MARK_COLUMNS,
    Assignment,
    Assignments,
    ClassMarks,
    StudentMarks,
    Submission,
    assignment_reply,
    mark_row,
    student_marks,
    submission_reply,
)
from modallab.api.assignments.schemas import AssignmentIn, SubmissionIn, TrialIn, WordsGradeIn
from modallab.api.classes import ClassesDep
from modallab.api.deps import IdPath, JobsDep, RequestKeyDep, SettingsDep, StoreDep
from modallab.api.examples import example
from modallab.api.jobs import JobReply, job_reply
from modallab.api.keys import KeysDep
from modallab.api.media import CsvWanted, csv_or, csv_replies
from modallab.api.wire import ID_PATTERN
from modallab.assignments.marking import marked
from modallab.core.errors import ModalLabError
from modallab.jobs.durations import duration_of_stepped_measurement
from modallab.jobs.measuring import MeasurementOptions
from modallab.jobs.sealing import SealedInputs
from modallab.jobs.tasks import SEALED_MEASUREMENT
from modallab.rig.setup import RigSetup
from modallab.store.assignments import AssignmentBook, StoredAssignment
from modallab.store.keys import Key, KeyBook, now
from modallab.store.plain import to_plain
from modallab.store.viewer import Visibility

router = APIRouter(prefix="/assignments", tags=["assignments"])

_ASSIGNMENT = {
    "class_id": "77ab10",
    "title": "Find the added mass",
    "structure": "5f0c31",
    "rig": {"drive": "1:+Y", "responses": ["1:+Y", "5:+Y", "9:+Y"], "noise": {"force": 1e-3}},
    "hidden": [
        {
            "kind": "extra_mass",
            "at": {"one_of": ["3:+Y", "7:+Y"]},
            "parameters": {"mass": {"between": [0.02, 0.08]}},
        }
    ],
    "choices": {"drive": {"one_of": ["1:+Y", "9:+Y"]}, "analyser.averages": {"between": [10, 100]}},
    "quota": 5,
    "diagnosis": "after_deadline",
    "deadline": "2030-01-31T18:00:00Z",
    "reveal": "2030-02-01T08:00:00Z",
    "rubric": {"kind": 2, "place": 2, "size": 1, "tolerance": 0.2, "words": 5},
}
_TRIAL = {"rig": {"drive": "9:+Y", "analyser": {"averages": 50}}}
_SUBMISSION = {
    "effects": [{"kind": "extra_mass", "at": "7:+Y", "parameters": {"mass": 0.05}}],
    "coefficients": {},
    "words": "The shapes of modes 2 and 3 bend towards node 7.",
}


_WORDS_GRADE = {"points": 4, "comment": "Right; what do the shapes say of node 9?"}


async def _assignments(request: Request) -> AssignmentBook:
    assignments: AssignmentBook = request.app.state.assignments
    return assignments


StudentPath = Annotated[str, Path(pattern=ID_PATTERN, description="id of the student's key")]
AssignmentsDep = Annotated[AssignmentBook, Depends(_assignments)]


@router.post(
    "", status_code=status.HTTP_201_CREATED, response_model=Assignment, summary="Create an assignment"
)
def create_assignment(
    body: Annotated[AssignmentIn, example(_ASSIGNMENT)],
    assignments: AssignmentsDep,
    classes: ClassesDep,
    store: StoreDep,
    caller: CallerDep,
    key: TeacherKeyDep,
) -> Any:
    """Return a new assignment for a class; its structure is shared with the class, its effects are not.

    Only for instructors and administrators. Effects with `between` and `one_of` are drawn for each student.
    """
    classes.get(body.class_id, viewer=key.viewer)
    given = body.structure
    structure = store.structures.get(given) if isinstance(given, str) else given.to_domain()
    assignment = body.to_domain(structure)
    structure_id = given if isinstance(given, str) else store.structures.add(structure, owner=key.id)
    stored = assignments.create(assignment, class_id=body.class_id, owner=key.id, structure_id=structure_id)
    return assignment_reply(stored, caller, [], None)


@router.get("", response_model=Assignments, summary="List assignments")
def list_assignments(assignments: AssignmentsDep, caller: CallerDep, key: KeyDep) -> Any:
    """Return the assignments of the caller's class, or of the caller's classes, newest first."""
    found = assignments.all(viewer=key.viewer)
    return Assignments(items=[_reply(assignments, stored, caller) for stored in found])


@router.get("/{id}", response_model=Assignment, summary="Get an assignment")
def get_assignment(id: IdPath, assignments: AssignmentsDep, caller: CallerDep, key: KeyDep) -> Any:
    """Return an assignment with the caller's measurements and last answer; students see nothing hidden."""
    return _reply(assignments, assignments.get(id, viewer=key.viewer), caller)


def _reply(assignments: AssignmentBook, stored: StoredAssignment, caller: Caller) -> Assignment:
    owner = caller.viewer.owner
    measurements = assignments.measurements(stored, [owner])[owner]
    return assignment_reply(stored, caller, measurements, assignments.submissions(stored, [owner]).get(owner))


@router.delete("/{id}", status_code=status.HTTP_204_NO_CONTENT, summary="Close an assignment")
def close_assignment(id: IdPath, assignments: AssignmentsDep, key: TeacherKeyDep) -> None:
    """List an assignment no more; measurements that students made stay, sealed as they are."""
    assignments.close(id, viewer=key.viewer)


@router.post(
    "/{id}/measurements",
    status_code=status.HTTP_202_ACCEPTED,
    response_model=JobReply,
    summary="Start a measurement of an assignment",
)
def start_assignment_measurement(
    id: IdPath,
    body: Annotated[TrialIn, example(_TRIAL)],
    assignments: AssignmentsDep,
    store: StoreDep,
    jobs: JobsDep,
    key: KeyDep,
    request_key: RequestKeyDep,
    settings: SettingsDep,
) -> Any:
    """Start a job that measures the assignment's structure with the caller's hidden effects.

    It counts against the quota, whatever becomes of it. Each has noise of its own: the same choice again
    does not repeat it, the same `Idempotency-Key` returns the same job.
    """
    stored = assignments.get(id, viewer=key.viewer)
    stored.assignment.check_open(now())
    route = body.route_of(stored.assignment)
    setup = body.rig_body(stored.assignment).to_domain()
    structure = store.structures.get(stored.structure_id)
    for dof in (*setup.drives, *setup.responses):
        structure.index(dof)
    # As of a nonlinear test, whether it is one or not.
    duration = duration_of_stepped_measurement(setup, route)
    duration.check(settings.job_seconds)
    number, is_new = assignments.take_trial(stored, key.id, None if request_key is None else request_key.key)
    inputs = SealedInputs(
        structure_id=stored.structure_id,
        rig_id=store.rigs.add(setup, owner=key.id, id=_rig_id(stored.id, key.id, setup)),
        assignment_id=stored.id,
        student=key.id,
        number=number,
        instructor=stored.owner,
    )
    options = MeasurementOptions(stored.hidden_from(key.id), route, stored.seed(key.id, number))
    arguments = SEALED_MEASUREMENT.arguments(inputs, options)
    try:
        job = jobs.submit(
            SEALED_MEASUREMENT.name, arguments, owner=key.id, lane=duration.lane, request=request_key
        )
    except ModalLabError:
        if is_new:
            assignments.give_back(stored, key.id, number)
        raise
    return job_reply(job)


def _rig_id(assignment_id: str, student: str, setup: RigSetup) -> str:
    """Return the id of a student's rig: a choice that is made again has the same one."""
    declared = json.dumps(to_plain(setup)[0], sort_keys=True)
    return sha256(f"{assignment_id}/{student}/{declared}".encode()).hexdigest()[:24]


@router.post(
    "/{id}/submissions",
    status_code=status.HTTP_201_CREATED,
    response_model=Submission,
    summary="Submit an answer",
)
def submit_answer(
    id: IdPath, body: Annotated[SubmissionIn, example(_SUBMISSION)], assignments: AssignmentsDep, key: KeyDep
) -> Any:
    """Return the marks of an answer, with reasons that tell what of it is right, and nothing beyond it."""
    stored = assignments.get(id, viewer=key.viewer)
    stored.assignment.check_open(now())
    answer = body.to_domain()
    marks = marked(answer, stored.hidden_from(key.id), stored.assignment.rubric)
    return submission_reply(assignments.submit(stored, key.id, answer, marks))


@router.get(
    "/{id}/marks", response_model=ClassMarks, responses=csv_replies(MARK_COLUMNS), summary="Get marks"
)
def get_marks(id: IdPath, assignments: AssignmentsDep, keys: KeysDep, key: KeyDep, as_csv: CsvWanted) -> Any:
    """Return the marks of the class to its instructor, and to a student the own ones: JSON or CSV."""
    stored = assignments.get(id, viewer=key.viewer)
    rows = _rows(assignments, keys, stored, key)
    return csv_or(lambda: ClassMarks(items=rows), MARK_COLUMNS, map(mark_row, rows), as_csv=as_csv)


@router.put("/{id}/marks/{student}/words", response_model=Submission, summary="Grade the words of an answer")
def grade_words(
    id: IdPath,
    student: StudentPath,
    body: Annotated[WordsGradeIn, example(_WORDS_GRADE)],
    assignments: AssignmentsDep,
    key: TeacherKeyDep,
) -> Any:
    """Return a student's last answer with points for its words; only for instructors and administrators.

    They replace those given before. A student who answers once more has none until they are given anew.
    """
    stored = assignments.get(id, viewer=key.viewer)
    return submission_reply(assignments.grade_words(stored, student, body.points, body.comment))


def _rows(
    assignments: AssignmentBook, keys: KeyBook, stored: StoredAssignment, key: Key
) -> list[StudentMarks]:
    is_student = key.viewer.visibility is Visibility.OWN
    students = [key] if is_student else keys.list(viewer=key.viewer, class_id=stored.class_id)
    ids = [student.id for student in students]
    measurements, answers = assignments.measurements(stored, ids), assignments.submissions(stored, ids)
    return [
        student_marks(student, measurements[student.id], answers.get(student.id))
        for student in sorted(students, key=attrgetter("name"))
    ]
