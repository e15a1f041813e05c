"""What a student may choose of a rig, and what not."""

import pytest

from modallab.assignments.choices import Choice, chosen_rig
from modallab.core.errors import InvalidInputError

FRAME = {"drive": "1:+Y", "responses": ["1:+Y", "5:+Y"], "analyser": {"n_lines": 101}, "noise": None}
CHOICES = {
    "drive": Choice(values=("1:+Y", "9:+Y")),
    "responses": Choice(values=("1:+Y", "5:+Y", "9:+Y")),
    "analyser.averages": Choice(5, 50),
    "noise.force": Choice(1e-4, 1e-2),
    "accelerometers.roving": Choice(values=(True,)),
}


def test_choices_are_put_into_the_frame() -> None:
    chosen = {"drive": "9:+Y", "responses": ["9:+Y"], "analyser": {"averages": 10}, "noise": {"force": 1e-3}}
    assert chosen_rig(FRAME, CHOICES, chosen) == {
        "drive": "9:+Y",
        "responses": ["9:+Y"],
        "analyser": {"n_lines": 101, "averages": 10},
        "noise": {"force": 1e-3},
    }


def test_the_frame_stays_as_it_is() -> None:
    assert chosen_rig(FRAME, CHOICES, {}) == FRAME
    chosen_rig(FRAME, CHOICES, {"analyser": {"averages": 10}})
    assert FRAME["analyser"] == {"n_lines": 101}


@pytest.mark.parametrize(
    ("chosen", "field"),
    [
        ({"drive": "5:+Y"}, "drive"),
        ({"responses": ["1:+Y", "2:+Y"]}, "responses"),
        ({"analyser": {"averages": 51}}, "analyser.averages"),
        ({"analyser": {"averages": "10"}}, "analyser.averages"),
        ({"analyser": {"averages": True}}, "analyser.averages"),
        ({"analyser": {"averages": None}}, "analyser.averages"),
        ({"analyser": {"n_lines": 201}}, "analyser.n_lines"),
        ({"analyser": None}, "analyser"),
        ({"noise": {"response": 0.0}}, "noise.response"),
        ({"accelerometers": {"roving": 1}}, "accelerometers.roving"),
        ({"effects": []}, "effects"),
        ({"analyser.averages": float("nan")}, "analyser.averages"),
    ],
)
def test_what_is_not_for_choice_is_refused_by_name(chosen: dict[str, object], field: str) -> None:
    with pytest.raises(InvalidInputError) as refusal:
        chosen_rig(FRAME, CHOICES, chosen)
    assert refusal.value.context["field"] == field
    assert refusal.value.context["allowed"]
