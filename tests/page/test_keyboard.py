"""Every view of the page by the keyboard alone: Tab, arrows, Enter, Space and letters, in a browser."""

from typing import Any

import pytest

from tests.page.conftest import KeyedService, Walk, check_step

STEPS = (
    "sign in",
    "plate",
    "rig",
    "measure",
    "extract",
    "poles",
    "correlate",
    "diagnose",
    "class",
    "student",
)


@pytest.fixture(scope="module")
def steps(walk: Walk, keyed: KeyedService) -> dict[str, Any]:
    """What the script says of each step."""
    return walk("by-keyboard.mjs", keyed.address, KEY=keyed.new_key("Lecturer by keys", "instructor"))


@pytest.mark.parametrize("name", STEPS)
def test_a_view_is_used_by_the_keyboard_alone(steps: dict[str, Any], name: str) -> None:
    """The script looks, too, whether Tab reaches every control in order, and the focus is always seen."""
    check_step(steps, name)


def test_the_diagnosis_names_the_hidden_effect(steps: dict[str, Any]) -> None:
    assert steps["diagnose"]["verdict"] == "Explained. Missing effect: extra mass at 9:+Y."


def test_the_student_has_marks(steps: dict[str, Any]) -> None:
    """Kind and place lie open to a student who guesses; how many points, depends on what was drawn."""
    assert steps["student"]["points"].endswith("of 5 points")
