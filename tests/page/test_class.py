"""A whole class in a browser: sealed for three students, who measure, extract, answer and get marks."""

import os
import subprocess
import sys
from typing import Any

import pytest

from tests.page.conftest import KeyedService, Walk, check_step

STEPS = ("keys", "assignment", "student one", "student two", "student three", "marks", "link")


@pytest.fixture(scope="module")
def lecturer(keyed: KeyedService) -> str:
    """Key of the instructor."""
    return keyed.new_key("Lecturer", "instructor")


@pytest.fixture(scope="module")
def steps(walk: Walk, keyed: KeyedService, lecturer: str) -> dict[str, Any]:
    """What the script says of each step."""
    return walk("class.mjs", keyed.address, KEY=lecturer)


@pytest.mark.parametrize("name", STEPS)
def test_a_step_of_a_class(steps: dict[str, Any], name: str) -> None:
    """The script looks, too, whether axe-core finds a serious violation, and at the width of a phone."""
    check_step(steps, name)


@pytest.mark.parametrize(
    ("name", "points", "reason"),
    [
        ("student one", "Marks: 5 of 5 points", "extra_mass at 9:+Y: the place is right."),
        ("student two", "Marks: 3 of 5 points", "extra_mass at 13:+Y: the place is not right."),
        ("student three", "Marks: 0 of 5 points", "ground_spring at 9:+Y: this kind is not right."),
    ],
)
def test_marks_have_their_reasons(steps: dict[str, Any], name: str, points: str, reason: str) -> None:
    """The hidden mass is 0.045 to 0.055 kg, and the page proposes 0.05: within the 20 % of the form."""
    assert steps[name]["points"] == points
    assert reason in steps[name]["reasons"]


def test_the_instructor_has_the_marks_of_all(steps: dict[str, Any]) -> None:
    head, *rows = steps["marks"]["table"]
    assert head.startswith("name,student,measurements,submitted")
    assert len(rows) == len(steps["marks"]["rows"]) == 3


def test_a_link_that_has_been_used_is_told_so(steps: dict[str, Any]) -> None:
    assert steps["link"]["told"].startswith("This link has been used, or is too old")


def printed(code: str, key: str) -> str:
    """Return what copied code prints with a key."""
    assert key not in code
    environment = os.environ | {"MODALLAB_KEY": key}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_marks_copied_as_python_are_those_of_the_table(steps: dict[str, Any], lecturer: str) -> None:
    assert printed(steps["marks"]["python"], lecturer).splitlines() == [
        "Student one 1 7.0",  # with the two points for words
        "Student three 1 0.0",
        "Student two 1 3.0",
    ]


def test_a_test_copied_as_python_is_that_of_the_student(steps: dict[str, Any], keyed: KeyedService) -> None:
    """One of two is left to the third student."""
    assert "(201,) (201, 11, 1)" in printed(
        steps["student three"]["python"], keyed.new_key_of("Student three")
    )
