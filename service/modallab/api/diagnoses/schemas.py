"""Wire types of diagnoses."""

from typing import Annotated, Any

from pydantic import Field, StringConstraints

from modallab.api.deps import Id
from modallab.api.derived import body_of, options_from
from modallab.api.diagnoses.follow_ups import FollowUpIn
from modallab.api.limits import REQUEST
from modallab.api.wire import Wanted
from modallab.core.dof import Dof
from modallab.diagnosis.options import DiagnosisOptions
from modallab.diagnosis.reporting.heading import ReportHeading
from modallab.fe.structure import Structure
from modallab.jobs.diagnosing import DiagnosisInputs
from modallab.rig.effect import EFFECTS

DiagnosisOptionsBody: Any = body_of(DiagnosisOptions, enforced=True)


class DiagnosisStart(DiagnosisOptionsBody):  # type: ignore[misc]
    """A model and a measurement that part; `act` runs the proposed next tests where the rig is ours."""

    structure_id: Id = Field(description="model that shall explain the measurement")
    measurement_id: Id = Field(description="measurement with its log book")
    follow_ups: list[FollowUpIn] = Field(
        default=[],
        max_length=REQUEST.follow_ups,
        description="further tests of the same structure, explained together with the first",
    )

    def to_task(self, structure: Structure) -> tuple[DiagnosisInputs, DiagnosisOptions]:
        """Return the task's inputs and options, checked as far as can be before the work.

        Raises
        ------
        InvalidInputError
            If a suspect is unknown.
        UnknownDofError
            If the structure lacks a DoF to hold out.
        """
        options = diagnosis_options(self)
        for text in options.hold_out.dofs:
            structure.index(Dof.parse(text, field="hold_out.dofs"))
        follow_ups = tuple(test.to_domain() for test in self.follow_ups)
        return DiagnosisInputs(self.structure_id, self.measurement_id, follow_ups), options


def diagnosis_options(body: Any) -> DiagnosisOptions:
    """Return the options of a diagnosis; `InvalidInputError` if one is out of bounds or a kind unknown."""
    options = options_from(DiagnosisOptions, body)
    for kind in options.suspects or ():
        EFFECTS[kind]
    return options


_Line = Annotated[str, StringConstraints(max_length=200, pattern=r"^[^\x00]*$")]


class ReportHeadingQuery(Wanted):
    """What a report says of itself at its top; left out: nothing."""

    title: _Line = ""
    """title above the finding"""
    object: _Line = ""
    """object that was tested"""
    author: _Line = ""
    """who made the test or the report"""
    date: _Line = ""
    """date of the test or the report"""

    def to_domain(self) -> ReportHeading:
        """Return the heading."""
        return ReportHeading(self.title, self.object, self.author, self.date)
