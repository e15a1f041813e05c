"""Wire types of assignments."""

from typing import Annotated, Any

from fastapi.exceptions import RequestValidationError
from pydantic import AwareDatetime, Field, ValidationError

from modallab.api.assignments.checks import ROUTE, check_terms, of_rig, routes_of
from modallab.api.deps import Id
from modallab.api.rigs.schemas import RigIn
from modallab.api.schema import Limits, NamedByPattern
from modallab.api.structures.schemas import StructureIn
from modallab.api.wire import (
    NO_CONVERSION,
    ChannelsAt,
    DofsAt,
    DofText,
    EffectIn,
    EffectKind,
    Fraction,
    HolderName,
    MembersAt,
    Number,
    Text,
    Wire,
)
from modallab.assignments.choices import Choice, chosen_rig
from modallab.assignments.hidden import HiddenEffect
from modallab.assignments.marking import Answer, ExpectedCoefficient, Rubric
from modallab.assignments.terms import AssignmentTerms, DiagnosisRule
from modallab.core.errors import InvalidInputError
from modallab.fe.structure import Structure
from modallab.rig.measure import Route
from modallab.store.keys import written

_Points = Annotated[Number, Limits(0.0, 1000.0)]
_At = DofText | DofsAt | MembersAt | ChannelsAt
_Value = bool | Number | Text


class BetweenIn(Wire):
    """An interval."""

    between: tuple[Number, Number]
    """lower and upper limit"""

    def limits(self, field: str) -> tuple[float, float]:
        """Return the limits; `InvalidInputError` if they are exchanged."""
        lower, upper = self.between
        if lower > upper:
            raise InvalidInputError(
                "the lower limit comes first", field=field, value=[lower, upper], allowed=[upper, lower]
            )
        return lower, upper


class PlacesIn(Wire):
    """Places, one of which is drawn for each student."""

    one_of: list[_At] = Field(min_length=1, max_length=1000)
    """places"""


class HiddenEffectIn(Wire):
    """An effect that students do not see, fixed or drawn for each of them."""

    kind: EffectKind
    """name of the effect; `GET /v1/catalog/effects` lists them"""
    at: _At | PlacesIn | None = None
    """place where it acts, or places to draw from; null: everywhere"""
    parameters: Annotated[dict[Text, Number | BetweenIn], NamedByPattern()] = Field(
        default_factory=dict, max_length=20
    )
    """numbers of the effect by name, SI units, or intervals to draw from"""

    def to_domain(self) -> HiddenEffect:
        """Return the template of the effect."""
        places = self.at.one_of if isinstance(self.at, PlacesIn) else [self.at]
        limits = {
            name: value.limits(f"hidden.{self.kind}.{name}")
            if isinstance(value, BetweenIn)
            else (value, value)
            for name, value in self.parameters.items()
        }
        at = tuple(EffectIn(kind=self.kind, at=place).place() for place in places)
        return HiddenEffect(self.kind, at, limits)


class ValuesIn(Wire):
    """Values that a student may choose from; of a field that is a list, for each of its entries."""

    one_of: list[_Value] = Field(min_length=1, max_length=1000)
    """values"""


class ExpectedIn(Wire):
    """Right value of an updated coefficient."""

    value: Number
    """right value"""
    tolerance: Fraction = 0.1
    """1, relative difference that counts as right"""


class RubricIn(Wire):
    """Points of an answer by criterion."""

    kind: _Points = 1.0
    """1, points for the kinds of the effects"""
    place: _Points = 1.0
    """1, points for the places of effects of the right kind"""
    size: _Points = 1.0
    """1, points for the parameters of effects of the right kind"""
    tolerance: Fraction = 0.2
    """1, relative difference of a parameter that counts as right"""
    coefficients: _Points = 0.0
    """1, points for updated coefficients"""
    expected: Annotated[dict[Text, ExpectedIn], NamedByPattern()] = Field(
        default_factory=dict, max_length=1000
    )
    """right coefficients by name; a student sees the names only"""
    words: _Points = 0.0
    """1, points for the words, which the instructor gives"""

    def to_domain(self) -> Rubric:
        """Return the rubric."""
        expected = {name: ExpectedCoefficient(e.value, e.tolerance) for name, e in self.expected.items()}
        return Rubric(**self.model_dump(exclude={"expected"}), expected=expected)


class AssignmentIn(Wire):
    """An assignment to be made."""

    class_id: Id
    """id of the class"""
    title: HolderName
    """title of the assignment"""
    structure: StructureIn | Id
    """analytical model, which the class may read: a description, or the id of a structure; what is under
    test has the hidden effects besides"""
    rig: RigIn
    """rig as it stands where a student chooses nothing"""
    hidden: list[HiddenEffectIn] = Field(default_factory=list, max_length=20)
    """effects that students do not see"""
    choices: Annotated[dict[Text, BetweenIn | ValuesIn], NamedByPattern()] = Field(
        default_factory=dict, max_length=100
    )
    """what a student may choose, with limits: fields of the rig, written with dots as `analyser.averages`,
    and `route`, which is sampled otherwise"""
    quota: Annotated[int, Field(ge=1, le=1000), NO_CONVERSION] = 5
    """1, measurements of each student"""
    submissions: Annotated[int, Field(ge=1, le=100), NO_CONVERSION] = 1
    """1, answers of each student; the last one counts"""
    diagnosis: DiagnosisRule = DiagnosisRule.OFF
    """whether students may diagnose the measurements"""
    deadline: AwareDatetime | None = None
    """end of measurements and answers; null: none"""
    reveal: AwareDatetime | None = None
    """time from which students see their hidden effects; null: never"""
    rubric: RubricIn = RubricIn()
    """points of an answer"""

    def to_domain(self, structure: Structure) -> AssignmentTerms:
        """Return the assignment, its hidden effects and choices checked on its structure.

        Raises
        ------
        InvalidInputError
            If a hidden effect is unknown, out of bounds or cannot be where it is said to; if a choice is no
            field of a rig, or a limit makes none.
        """
        setup = self.rig.to_domain()
        for dof in (*setup.drives, *setup.responses):
            structure.index(dof)
        assignment = AssignmentTerms(
            title=self.title,
            rig=self.rig.model_dump(mode="json", exclude_unset=True),
            choices={path: _choice(path, limits) for path, limits in self.choices.items()},
            quota=self.quota,
            submissions=self.submissions,
            diagnosis=self.diagnosis,
            deadline=None if self.deadline is None else written(self.deadline),
            reveal=None if self.reveal is None else written(self.reveal),
            hidden=tuple(effect.to_domain() for effect in self.hidden),
            rubric=self.rubric.to_domain(),
        )
        check_terms(assignment, structure, setup)
        return assignment


class TrialIn(Wire):
    """A measurement of an assignment."""

    rig: Annotated[dict[Text, Any], NamedByPattern()] = Field(default_factory=dict, max_length=100)
    """part of the body of a rig: the fields that the assignment lets one choose"""
    route: Route | None = None
    """how the measurement comes about; null: the first that the assignment allows"""

    def rig_body(self, assignment: AssignmentTerms) -> RigIn:
        """Return the rig of the assignment with the student's choices.

        Raises
        ------
        InvalidInputError
            If something is not the student's to choose, or out of the limits.
        RequestValidationError
            If that makes no rig.
        """
        chosen = chosen_rig(assignment.rig, of_rig(assignment.choices), self.rig)
        try:
            return RigIn.model_validate(chosen)
        except ValidationError as error:
            faults = [fault | {"loc": ("body", "rig", *fault["loc"])} for fault in error.errors()]
            raise RequestValidationError(faults, body={"rig": chosen}) from None

    def route_of(self, assignment: AssignmentTerms) -> Route:
        """Return the route; `InvalidInputError` if the assignment does not allow it."""
        allowed = routes_of(assignment)
        if self.route is not None and self.route not in allowed:
            raise InvalidInputError(
                "the assignment allows other routes",
                field=ROUTE,
                value=self.route.value,
                allowed=[route.value for route in allowed],
            )
        return self.route or allowed[0]


class SubmissionIn(Wire):
    """What a student says of a test."""

    effects: list[EffectIn] = Field(default_factory=list, max_length=50)
    """effects that the test has and its log book does not tell"""
    coefficients: Annotated[dict[Text, Number], NamedByPattern()] = Field(
        default_factory=dict, max_length=1000
    )
    """updated coefficients by name"""
    words: str = Field("", max_length=10_000, pattern=r"^[^\x00]*$")
    """words for the instructor"""

    def to_domain(self) -> Answer:
        """Return the answer; the values of its effects are as they were sent."""
        specs = []
        for effect in self.effects:
            effect.to_domain()  # an unknown parameter, or a value out of bounds, is a slip and no answer
            specs.append(effect.spec())
        return Answer(tuple(specs), dict(self.coefficients), self.words)


class WordsGradeIn(Wire):
    """Points that the instructor gives for the words of an answer."""

    points: _Points
    """1, points, at most those of the rubric"""
    comment: str = Field("", max_length=2000, pattern=r"^[^\x00]*$")
    """reason, which the student reads"""


def _choice(path: str, limits: BetweenIn | ValuesIn) -> Choice:
    if isinstance(limits, ValuesIn):
        return Choice(values=tuple(limits.one_of))
    lower, upper = limits.limits(f"choices.{path}")
    return Choice(lower, upper)
