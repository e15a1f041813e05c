"""Wire types of diagnoses."""

from typing import Annotated, Any, Literal

from pydantic import Field

from modallab.api.deps import Id
from modallab.api.derived import body_of
from modallab.api.diagnoses.follow_ups import FollowUpIn
from modallab.api.diagnoses.tolerated import TolerancesIn
from modallab.api.limits import REQUEST
from modallab.api.wire import NO_CONVERSION, NoiseFloor, Text
from modallab.core.dof import Dof
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.options import DiagnosisOptions, HoldOut
from modallab.fe.structure import Structure
from modallab.jobs.diagnosing import DiagnosisInputs
from modallab.rig.effect import EFFECTS

Kinds = Annotated[list[Text], Field(min_length=1, max_length=100)]


DiagnosisOptionsBody: Any = body_of(
    DiagnosisOptions,
    suspects=Literal["all"] | Kinds,
    tolerances=TolerancesIn,
    noise_floor=NoiseFloor | None,
    max_effects=Annotated[int, Field(ge=1, le=8), NO_CONVERSION],
)


class DiagnosisStart(DiagnosisOptionsBody):  # type: ignore[misc]
    """A model and a measurement that part; `act` runs the proposed next tests where the rig is ours."""

    suspects: Literal["all"] | Kinds = Field(default="all", description="kinds of effects to look for")
    structure_id: Id
    measurement_id: Id
    follow_ups: list[FollowUpIn] = Field(default=[], max_length=REQUEST.follow_ups)

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
    suspects = None if body.suspects in (None, "all") else tuple(body.suspects)
    for kind in suspects or ():
        EFFECTS[kind]
    return DiagnosisOptions(
        suspects,
        HoldOut(body.hold_out.fraction, tuple(body.hold_out.dofs)),
        Tolerances(**body.tolerances.model_dump()),
        body.act,
        body.noise_floor,
        body.max_effects,
        body.seed,
    )
