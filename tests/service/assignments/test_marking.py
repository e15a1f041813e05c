"""Marks: points by the rubric, and reasons that tell nothing beyond the answer."""

import pytest

from modallab.assignments.marking import (
    Answer,
    ExpectedCoefficient,
    Mark,
    Marks,
    Rubric,
    marked,
    with_points_for_words,
)
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.place import Channels, EffectSpec, Members

MASS = EffectSpec("extra_mass", Dof(7, "Y"), {"mass": 0.05})
CRACK = EffectSpec("member_stiffness", Members((3, 4)), {"factor": 0.8})
RUBRIC = Rubric(kind=2, place=2, size=1, tolerance=0.2)


def marks_of(*effects: EffectSpec, truth: tuple[EffectSpec, ...] = (MASS,), rubric: Rubric = RUBRIC) -> Marks:
    return marked(Answer(effects, {}, ""), truth, rubric)


def points(marks: Marks) -> dict[str, float | None]:
    return {mark.criterion: mark.points for mark in marks.marks}


@pytest.mark.parametrize(
    ("answer", "expected"),
    [
        (MASS, {"kind": 2, "place": 2, "size": 1}),
        (EffectSpec("extra_mass", Dof(7, "Y", -1), {"mass": 0.0599}), {"kind": 2, "place": 2, "size": 1}),
        (EffectSpec("extra_mass", Dof(7, "Y"), {"mass": 0.061}), {"kind": 2, "place": 2, "size": 0}),
        (EffectSpec("extra_mass", Dof(7, "Y")), {"kind": 2, "place": 2, "size": 0}),
        (EffectSpec("extra_mass", Dof(6, "Y"), {"mass": 0.05}), {"kind": 2, "place": 0, "size": 1}),
        (EffectSpec("ground_spring", Dof(7, "Y"), {"mass": 0.05}), {"kind": 0, "place": 0, "size": 0}),
    ],
)
def test_each_criterion_is_judged_by_itself_once_the_kind_is_right(
    answer: EffectSpec, expected: dict[str, float]
) -> None:
    marks = marks_of(answer)
    assert points(marks) == expected
    assert (marks.points, marks.maximum) == (sum(expected.values()), 5)


def test_what_is_missed_and_what_is_invented_cost_the_same_share() -> None:
    missed = marks_of(MASS, truth=(MASS, CRACK))
    invented = marks_of(MASS, CRACK)
    assert points(missed) == points(invented) == {"kind": 1, "place": 1, "size": 0.5}
    assert "There is an effect that the answer does not name." in missed.marks[0].reasons
    assert "There is an effect that the answer does not name." not in invented.marks[0].reasons


def test_effects_are_compared_in_the_best_order() -> None:
    assert marks_of(CRACK, MASS, truth=(MASS, CRACK)).points == 5
    twins = (MASS, EffectSpec("extra_mass", Dof(2, "Y"), {"mass": 0.1}))
    assert marks_of(*reversed(twins), truth=twins).points == 5


def test_places_have_no_order() -> None:
    swapped = EffectSpec("member_stiffness", Members((4, 3)), {"factor": 0.8})
    assert marks_of(swapped, truth=(CRACK,)).points == 5
    wires = (Channels((Dof(1, "Y"), Dof(5, "Y", -1))), Channels((Dof(5, "Y"), Dof(1, "Y"))))
    named, hidden = (EffectSpec("polarity", at) for at in wires)
    assert marks_of(named, truth=(hidden,)).points == 5


def test_a_sound_structure_is_found_by_naming_nothing() -> None:
    assert marks_of(truth=()).points == 5
    assert marks_of(MASS, truth=()).points == 0
    assert marks_of().points == 0


WORDED = marked(Answer((), {}, "bent"), (), Rubric(kind=1, place=1, size=1, words=3))


@pytest.mark.parametrize("points", [0.0, 1.5, 3.0])
def test_points_for_words_are_the_instructors(points: float) -> None:
    assert (WORDED.points, WORDED.maximum) == (3.0, 3.0)  # nothing is hidden, and the answer names nothing
    given = with_points_for_words(WORDED, points, "Well seen.")
    assert (given.points, given.maximum) == (3.0 + points, 6.0)
    assert given.marks[-1] == Mark("words", points, 3.0, ("Well seen.",))
    assert with_points_for_words(given, 2.0).points == 5.0  # in place of those before


@pytest.mark.parametrize("points", [-0.1, 3.1])
def test_no_other_points_than_those_of_the_rubric_are_given(points: float) -> None:
    with pytest.raises(InvalidInputError) as refused:
        with_points_for_words(WORDED, points)
    assert refused.value.context["field"] == "points"
    assert refused.value.context["allowed"] == {"minimum": 0.0, "maximum": 3.0}


def test_a_rubric_without_words_has_no_points_for_them() -> None:
    with pytest.raises(InvalidInputError, match="no points for words"):
        with_points_for_words(marked(Answer((), {}, "bent"), (), Rubric()), 0.0)


def test_coefficients_and_words() -> None:
    right = {"E": ExpectedCoefficient(0.9, 0.05), "rho": ExpectedCoefficient(1.0, 0.1)}
    rubric = Rubric(kind=0, place=0, size=0, coefficients=4, expected=right, words=3)
    marks = marked(Answer((), {"E": 0.93}, "because"), (), rubric)
    assert [(mark.criterion, mark.points, mark.maximum) for mark in marks.marks] == [
        ("coefficients", 2, 4),
        ("words", None, 3),
    ]
    assert (marks.points, marks.maximum) == (2, 4)
    assert marks.marks[0].reasons == ("E is right.", "rho is not stated.")


def test_reasons_tell_nothing_that_the_answer_does_not_say() -> None:
    wrong = EffectSpec("extra_mass", Dof(6, "Y"), {"mass": 0.02})
    spring = EffectSpec("ground_spring", Dof(2, "Y"), {"stiffness": 1e4})
    text = str(marks_of(wrong, spring, truth=(MASS, CRACK)))
    assert not [
        secret for secret in ("7:+Y", "0.05", "member_stiffness", "factor", "0.8", "3, 4") if secret in text
    ]
