"""Assignments: tests with hidden effects that an instructor sets a class."""

from collections.abc import Mapping, Sequence
from typing import Any

from modallab_client import _wire
from modallab_client._generated import models
from modallab_client._sync.jobs import Job
from modallab_client._sync.measurements import Measurements
from modallab_client._sync.transport import Transport
from modallab_client.results import Assignment, EffectSpec, Measurement, StudentMarks, Submission
from modallab_client.stored import Identified, id_of

JsonObject = Mapping[str, Any]


class Assignments:
    """Assignments on the service."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport

    def create(
        self,
        class_id: str,
        title: str,
        *,
        structure: Identified | JsonObject,
        rig: JsonObject,
        hidden: Sequence[JsonObject] = (),
        choices: JsonObject | None = None,
        quota: int | None = None,
        submissions: int | None = None,
        diagnosis: str | None = None,
        deadline: str | None = None,
        reveal: str | None = None,
        rubric: JsonObject | None = None,
    ) -> Assignment:
        """Return a new assignment; for instructors.

        Parameters
        ----------
        class_id, title
            Class that it is for, and its title.
        structure
            Analytical model, which students see: a structure, its id, or a description.
        rig
            Rig as it stands where a student chooses nothing.
        hidden
            Effects that students do not see: `{"kind", "at", "parameters"}`. `{"one_of": [...]}` for `at` and
            `{"between": [a, b]}` for a parameter are drawn for each student.
        choices
            What a student may choose: `{"analyser.averages": {"between": [5, 50]}}`, or `{"one_of": [...]}`.
        quota, submissions
            Measurements and answers of each student.
        diagnosis
            `off`, `on` or `after_deadline`.
        deadline, reveal
            End of measurements and answers; time from which students see what was hidden: ISO 8601.
        rubric
            Points of an answer: `kind`, `place`, `size`, `tolerance`, `coefficients`, `expected`, `words`.
        """
        described = structure if isinstance(structure, Mapping) else id_of(structure)
        body = {"class_id": class_id, "title": title, "structure": described, "rig": rig}
        times = _wire.body(deadline=deadline, reveal=reveal, quota=quota, submissions=submissions)
        more = _wire.body(choices=choices, diagnosis=diagnosis, rubric=rubric)
        whole = body | times | more | {"hidden": list(hidden)}
        return _wire.reply(Assignment, self._transport.request("POST", "/v1/assignments", json=whole))

    def list(self) -> tuple[Assignment, ...]:
        """Return the assignments of one's class, or of one's classes, newest first."""
        return _wire.reply(models.Assignments, self._transport.request("GET", "/v1/assignments")).items

    def get(self, assignment_id: Identified) -> Assignment:
        """Return an assignment with one's measurements and last answer."""
        return _wire.reply(Assignment, self._transport.request("GET", _path(assignment_id)))

    def close(self, assignment_id: Identified) -> None:
        """List an assignment no more; its measurements stay, sealed as they are."""
        self._transport.request("DELETE", _path(assignment_id))

    def measure(
        self, assignment_id: Identified, rig: JsonObject | None = None, *, route: str | None = None
    ) -> Job[Measurement]:
        """Start a measurement; it counts against the quota.

        Parameters
        ----------
        rig
            What one chooses: `{"drive": "9:+Y", "analyser": {"averages": 20}}`.
        route
            `sampled`, or another that the assignment allows.
        """
        body = {"rig": {} if rig is None else rig} | _wire.body(route=route)
        path = f"{_path(assignment_id)}/measurements"
        job = self._transport.request("POST", path, json=body)
        return Job(job["id"], self._transport, Measurements(self._transport).get)

    def submit(
        self,
        assignment_id: Identified,
        effects: Sequence[JsonObject | EffectSpec] = (),
        *,
        coefficients: Mapping[str, float] | None = None,
        words: str = "",
    ) -> Submission:
        """Return the marks of an answer, with reasons.

        Parameters
        ----------
        effects
            Effects found, `{"kind", "at", "parameters"}`, also those of a diagnosis.
        coefficients
            Updated coefficients by the names that the assignment asks for.
        words
            Words for the instructor.
        """
        body = {"effects": list(effects), "coefficients": dict(coefficients or {}), "words": words}
        path = f"{_path(assignment_id)}/submissions"
        return _wire.reply(Submission, self._transport.request("POST", path, json=body))

    def marks(self, assignment_id: Identified) -> tuple[StudentMarks, ...]:
        """Return the marks of the class to its instructor, to a student the own ones."""
        path = f"{_path(assignment_id)}/marks"
        return _wire.reply(models.ClassMarks, self._transport.request("GET", path)).items

    def grade_words(
        self, assignment_id: Identified, student: str, points: float, *, comment: str = ""
    ) -> Submission:
        """Return a student's last answer with points for its words; for instructors.

        Parameters
        ----------
        student
            Id of the student's key, `student` of a row of the marks.
        points
            At most those that the rubric gives for words.
        comment
            Reason, which the student reads.
        """
        path = f"{_path(assignment_id)}/marks/{student}/words"
        body = {"points": points, "comment": comment}
        return _wire.reply(Submission, self._transport.request("PUT", path, json=body))


def _path(assignment_id: Identified) -> str:
    return f"/v1/assignments/{id_of(assignment_id)}"
