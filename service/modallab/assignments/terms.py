"""Assignments: a structure, a test that students choose within limits, and what is hidden in it."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from modallab.assignments.choices import Choice
from modallab.assignments.hidden import HiddenEffect
from modallab.assignments.marking import Rubric
from modallab.core.errors import ModalLabError


class AssignmentError(ModalLabError):
    """The assignment does not allow this."""

    code = "assignment"


class DiagnosisRule(StrEnum):
    """Whether students may diagnose the measurements of an assignment."""

    OFF = "off"
    ON = "on"
    AFTER_DEADLINE = "after_deadline"


@dataclass(frozen=True)
class AssignmentTerms:
    """What an instructor sets a class."""

    title: str
    """Title of the assignment."""
    rig: Mapping[str, Any]
    """Body of `POST /v1/rigs`: the frame, which holds where a student chooses nothing."""
    choices: Mapping[str, Choice]
    """Limits of the fields that a student may choose, by field; `route` beside those of the rig."""
    quota: int
    """1, measurements of each student."""
    submissions: int
    """1, answers of each student; the last one counts."""
    diagnosis: DiagnosisRule
    """Whether students may diagnose its measurements."""
    deadline: str | None
    """ISO 8601, UTC, end of measurements and answers; None: no end."""
    reveal: str | None
    """ISO 8601, UTC, time from which students see their hidden effects; None: never."""
    hidden: tuple[HiddenEffect, ...]
    """Hidden effects or their templates."""
    rubric: Rubric
    """Points of an answer."""

    def allows_diagnosis(self, time: str) -> bool:
        """Return whether a student may diagnose at a time, ISO 8601, UTC."""
        if self.diagnosis is DiagnosisRule.AFTER_DEADLINE:
            return self.is_over(time)
        return self.diagnosis is DiagnosisRule.ON

    def is_over(self, time: str) -> bool:
        """Return whether the deadline has passed."""
        return self.deadline is not None and time >= self.deadline

    def is_revealed(self, time: str) -> bool:
        """Return whether students may see what was hidden from them."""
        return self.reveal is not None and time >= self.reveal

    def check_open(self, time: str) -> None:
        """Raise `AssignmentError` if the deadline has passed."""
        if self.is_over(time):
            raise AssignmentError(
                "the deadline has passed", field="deadline", value=time, allowed=f"before {self.deadline}"
            )
