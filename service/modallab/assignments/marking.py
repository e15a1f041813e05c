"""Marks of an answer, with reasons: they tell what of the answer is right, and nothing beyond it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import linear_sum_assignment

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.place import Channels, Dofs, EffectSpec, Members, Place


@dataclass(frozen=True)
class ExpectedCoefficient:
    """Right value of an updated coefficient."""

    value: float
    """Right value, in the unit of the coefficient."""
    tolerance: float
    """1, relative difference that counts as right."""


@dataclass(frozen=True)
class Rubric:
    """Points of an answer by criterion, each shared equally by what is judged."""

    kind: float = 1.0
    """1, points for the kinds of the effects."""
    place: float = 1.0
    """1, points for the places of effects of the right kind."""
    size: float = 1.0
    """1, points for the parameters of effects of the right kind."""
    tolerance: float = 0.2
    """1, relative difference of a parameter that counts as right."""
    coefficients: float = 0.0
    """1, points for updated coefficients."""
    expected: Mapping[str, ExpectedCoefficient] = field(default_factory=dict)
    """Right coefficients by name."""
    words: float = 0.0
    """1, points for the words, which the instructor gives."""


@dataclass(frozen=True)
class Answer:
    """What a student says of a test."""

    effects: tuple[EffectSpec, ...]
    """Effects that the test has and its log book does not tell."""
    coefficients: Mapping[str, float]
    """Updated coefficients by name."""
    words: str
    """Words for the instructor."""


@dataclass(frozen=True)
class Mark:
    """Points of one criterion."""

    criterion: str
    """`kind`, `place`, `size`, `coefficients` or `words`."""
    points: float | None
    """1, points reached; None: the instructor has still to give them."""
    maximum: float
    """1, points that can be reached."""
    reasons: tuple[str, ...]
    """What is right and what is not, a sentence each."""


@dataclass(frozen=True)
class Marks:
    """Points of an answer."""

    points: float
    """1, points reached, without those that the instructor has still to give."""
    maximum: float
    """1, points that can be reached, without those that the instructor has still to give."""
    marks: tuple[Mark, ...]
    """Points by criterion."""


@dataclass(frozen=True)
class _Judgement:
    """Shares of one effect of the answer, compared with one hidden effect."""

    kind: float
    place: float
    size: float
    reasons: Mapping[str, tuple[str, ...]]


def marked(answer: Answer, truth: Sequence[EffectSpec], rubric: Rubric) -> Marks:
    """Return the marks of an answer.

    Each effect of the answer is compared with the hidden one by which it gets the most points. What was not
    found, and what was named without being there, reduce the share that is right.

    Parameters
    ----------
    truth
        Hidden effects; their parameters are the ones judged.
    """
    judgements = _judgements(answer.effects, truth, rubric)
    n = max(len(truth), len(answer.effects))
    missed = len(truth) > sum(judgement.kind for judgement in judgements)
    marks = [
        _mark_of_effects(name, getattr(rubric, name), judgements, n, missed=missed)
        for name in ("kind", "place", "size")
    ]
    if rubric.expected:
        marks.append(_mark_of_coefficients(answer.coefficients, rubric))
    if rubric.words:
        marks.append(Mark("words", None, rubric.words, ("The instructor reads the words.",)))
    return _with_totals(marks)


def with_points_for_words(marks: Marks, points: float, comment: str = "") -> Marks:
    """Return the marks with the instructor's points for the words.

    Parameters
    ----------
    points
        1, at most the points that the rubric gives for words.
    comment
        What the student reads as the reason.

    Raises
    ------
    InvalidInputError
        If the rubric gives no points for words, or fewer.
    """
    maximum = next((mark.maximum for mark in marks.marks if mark.criterion == "words"), None)
    if maximum is None:
        raise InvalidInputError("the rubric of this assignment gives no points for words", field="points")
    if not 0.0 <= points <= maximum:
        allowed = bounds(minimum=0.0, maximum=maximum)
        raise InvalidInputError(
            "the rubric gives other points for words", field="points", value=points, allowed=allowed
        )
    words_mark = Mark("words", points, maximum, (comment,) if comment else ())
    return _with_totals([words_mark if mark.criterion == "words" else mark for mark in marks.marks])


def _with_totals(marks: Sequence[Mark]) -> Marks:
    given = [mark for mark in marks if mark.points is not None]
    return Marks(
        points=sum(mark.points or 0.0 for mark in given),
        maximum=sum(mark.maximum for mark in given),
        marks=tuple(mark for mark in marks if mark.maximum > 0),
    )


def _judgements(named: Sequence[EffectSpec], truth: Sequence[EffectSpec], rubric: Rubric) -> list[_Judgement]:
    """Return the judgement of each effect of the answer, paired with hidden ones for the most points."""
    if not named:
        return []
    wrong = [_compared(effect, None, rubric) for effect in named]
    if not truth:
        return wrong
    table = [[_compared(effect, hidden, rubric) for hidden in truth] for effect in named]
    # Among equal points the pair of equal kinds counts, whatever the rubric gives for kinds.
    worth = [[_worth(judgement, rubric) for judgement in row] for row in table]
    for row, column in zip(*linear_sum_assignment(np.array(worth), maximize=True), strict=True):
        wrong[row] = table[row][column]
    return wrong


def _worth(judgement: _Judgement, rubric: Rubric) -> float:
    points = rubric.kind * judgement.kind + rubric.place * judgement.place + rubric.size * judgement.size
    return points + 1e-6 * judgement.kind


def _compared(named: EffectSpec, hidden: EffectSpec | None, rubric: Rubric) -> _Judgement:
    title = named.kind if named.at is None else f"{named.kind} at {named.at}"
    if hidden is None or named.kind != hidden.kind:
        unjudged = (f"{title}: not judged, for its kind is not right.",)
        reasons: dict[str, tuple[str, ...]]
        reasons = {"kind": (f"{title}: this kind is not right.",), "place": unjudged, "size": unjudged}
        return _Judgement(0.0, 0.0, 0.0, reasons)
    is_there = _point_set(named.at) == _point_set(hidden.at)
    place = f"{title}: the place is {'right' if is_there else 'not right'}."
    sizes = {
        name: _is_close(named.parameters.get(name), value, rubric.tolerance)
        for name, value in hidden.parameters.items()
    }
    size = tuple(f"{title}: {_size_words(name, named, right, rubric)}" for name, right in sizes.items())
    share = sum(sizes.values()) / len(sizes) if sizes else 1.0
    reasons = {"kind": (f"{title}: the kind is right.",), "place": (place,), "size": size}
    return _Judgement(1.0, float(is_there), share, reasons)


def _size_words(name: str, named: EffectSpec, is_right: bool, rubric: Rubric) -> str:
    if name not in named.parameters:
        return f"{name} is not stated."
    within = f"within {100 * rubric.tolerance:g} %"
    return f"{name} is {'right' if is_right else 'not right'} {within}."


def _is_close(value: float | None, right: float, tolerance: float) -> bool:
    return value is not None and abs(value - right) <= tolerance * abs(right)


def _point_set(place: Place) -> object:
    """Return a place without order and without the sense of its DoFs."""
    match place:
        case Dofs() | Channels():
            return type(place), frozenset(dof.point for dof in place.dofs)
        case Members():
            return frozenset(place.numbers)
        case Dof():
            return place.point
        case None:
            return None


def _mark_of_effects(
    name: str, maximum: float, judgements: Sequence[_Judgement], n: int, *, missed: bool
) -> Mark:
    share = sum(getattr(judgement, name) for judgement in judgements) / n if n else 1.0
    reasons = [reason for judgement in judgements for reason in judgement.reasons[name]]
    if missed:
        reasons.append("There is an effect that the answer does not name.")
    elif not judgements:
        reasons.append("There is no hidden effect, and the answer names none.")
    return Mark(name, maximum * share, maximum, tuple(reasons))


def _mark_of_coefficients(stated: Mapping[str, float], rubric: Rubric) -> Mark:
    right = {
        name: _is_close(stated.get(name), expected.value, expected.tolerance)
        for name, expected in rubric.expected.items()
    }
    reasons = tuple(
        f"{name} is {'not stated' if name not in stated else 'right' if is_right else 'not right'}."
        for name, is_right in right.items()
    )
    points = rubric.coefficients * sum(right.values()) / len(right)
    return Mark("coefficients", points, rubric.coefficients, reasons)
