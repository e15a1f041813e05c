"""Checks of new assignments: each choice makes a rig, each hidden effect has its places."""

from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import ValidationError

from modallab.api.rigs.schemas import RigIn
from modallab.assignments.choices import Choice, chosen_rig
from modallab.assignments.drawing import Lot
from modallab.assignments.hidden import HiddenEffect
from modallab.assignments.terms import AssignmentTerms, DiagnosisRule
from modallab.core.errors import InvalidInputError
from modallab.fe.structure import Structure
from modallab.rig.effect import Effect, Stage, build
from modallab.rig.measure import Route
from modallab.rig.setup import RigSetup

ROUTE = "route"  # what a student chooses beside the rig


def check_terms(assignment: AssignmentTerms, structure: Structure, setup: RigSetup) -> None:
    """Raise `InvalidInputError` where students could not do what an assignment says.

    Parameters
    ----------
    setup
        Rig as it stands where a student chooses nothing.
    """
    _check_times(assignment)
    _check_choices(assignment)
    _check_hidden(assignment, structure, setup)


def routes_of(assignment: AssignmentTerms) -> list[Route]:
    """Return the routes that an assignment allows, the usual one first."""
    choice = assignment.choices.get(ROUTE)
    return [Route.SAMPLED] if choice is None else [Route(str(value)) for value in choice.values]


def _check_times(assignment: AssignmentTerms) -> None:
    """Raise `InvalidInputError` if a time is missing, or they are in the wrong order."""
    deadline, reveal = assignment.deadline, assignment.reveal
    if deadline is None and assignment.diagnosis is DiagnosisRule.AFTER_DEADLINE:
        raise InvalidInputError(
            "without a deadline there is nothing after it", field="deadline", allowed="a time"
        )
    if deadline is not None and reveal is not None and reveal < deadline:
        raise InvalidInputError(
            "students would see what is hidden while they measure",
            field="reveal",
            value=reveal,
            allowed=f"{deadline} or later",
        )


def of_rig(choices: Mapping[str, Choice]) -> dict[str, Choice]:
    """Return the choices that are fields of the rig."""
    return {path: choice for path, choice in choices.items() if path != ROUTE}


def _check_choices(assignment: AssignmentTerms) -> None:
    """Raise `InvalidInputError` if a limit of a choice makes no rig."""
    known = [route.value for route in Route]
    route = assignment.choices.get(ROUTE)
    if route is not None and (not route.values or any(value not in known for value in route.values)):
        raise InvalidInputError("these are no routes", field=f"choices.{ROUTE}", allowed={"one_of": known})
    for path, choice in of_rig(assignment.choices).items():
        for value in choice.values or (choice.lower, choice.upper):
            if not _makes_a_rig(assignment, path, value):
                raise InvalidInputError(
                    "no field of a rig, or a value that it cannot have: whole rigs are tried with the frame",
                    field=f"choices.{path}",
                    value=value,
                    allowed="a field of a rig, written with dots, such as analyser.averages",
                )


def _makes_a_rig(assignment: AssignmentTerms, path: str, value: Any) -> bool:
    """Return whether the frame with one choice is a rig; a list may have the value as its entry."""
    whole = int(value) if isinstance(value, float) and value.is_integer() else value
    return any(_is_rig(assignment, path, tried) for tried in (whole, [whole]))


def _is_rig(assignment: AssignmentTerms, path: str, value: Any) -> bool:
    *parts, last = path.split(".")
    chosen: dict[str, Any] = {last: value}
    for part in reversed(parts):
        chosen = {part: chosen}
    allowed = Choice(values=tuple(value) if isinstance(value, list) else (value,))
    try:
        RigIn.model_validate(chosen_rig(assignment.rig, {path: allowed}, chosen)).to_domain()
    except (ValidationError, InvalidInputError):
        return False
    return True


def _check_hidden(assignment: AssignmentTerms, structure: Structure, setup: RigSetup) -> None:
    """Raise `InvalidInputError` if a hidden effect cannot be what it may be drawn as."""
    only_sampled = routes_of(assignment) == [Route.SAMPLED]
    for effect in _extremes(assignment.hidden):
        effect.check(structure, setup)
        if effect.stage is Stage.MOTION and not only_sampled:
            raise InvalidInputError(
                f"{effect.kind} is nonlinear: other routes would tell it, by what they leave out",
                field=f"choices.{ROUTE}",
                value=effect.kind,
                allowed=[Route.SAMPLED.value],
            )


def _extremes(hidden: Iterable[HiddenEffect]) -> Iterable[Effect]:
    # One drawn between the limits too: of whole numbers there may be none.
    between = Lot("", "between")
    return (build(spec) for effect in hidden for spec in (*effect.extremes(), effect.effect_for(between)))
