"""What a diagnosis offers beyond its verdict, in a browser: an unknown effect adopted, a next test run."""

from typing import Any

import pytest

from tests.page.conftest import Walk, check_step


@pytest.fixture(scope="module")
def steps(walk: Walk, address: str) -> dict[str, Any]:
    """What the script says of each step."""
    return walk("explain.mjs", address)


@pytest.mark.parametrize("name", ["unknown effect", "next test"])
def test_a_step_of_a_student(steps: dict[str, Any], name: str) -> None:
    check_step(steps, name)


def test_the_law_of_the_unknown_effect_is_that_of_the_hidden_oscillator(steps: dict[str, Any]) -> None:
    assert steps["unknown effect"]["law"].startswith("Its law is that of: oscillator; mass 0.050")
