"""A student's way through the page in a browser, by the keyboard: rig, measure, extract, correlate, diagnose.

The script looks, too, whether axe-core finds a serious violation in any view, light or dark, whether a view
is wider than 400 px, and whether the browser complains or asks another host.
"""

import subprocess
import sys
from typing import Any

import pytest

from tests.page.conftest import Walk, check_step

STEPS = (
    *("first load", "rig", "measure", "extract", "correlate"),
    *("diagnose", "own files", "shared address", "errors", "reference", "class", "saved work"),
)


@pytest.fixture(scope="module")
def steps(walk: Walk, address: str) -> dict[str, Any]:
    """What the script says of each step."""
    return walk("path.mjs", address)


@pytest.mark.parametrize("name", STEPS)
def test_a_step_of_a_student(steps: dict[str, Any], name: str) -> None:
    check_step(steps, name)


def test_the_diagnosis_names_the_hidden_effect(steps: dict[str, Any]) -> None:
    assert steps["diagnose"]["verdict"] == "Explained. Missing effect: extra mass at 9:+Y."


@pytest.mark.parametrize("name", ["measure", "extract"])
def test_what_is_copied_as_python_runs(steps: dict[str, Any], name: str) -> None:
    done = subprocess.run([sys.executable, "-c", steps[name]["python"]], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    expected = {"measure": "(401,) (401, 11, 1)", "extract": "frequency"}[name]
    assert expected in done.stdout
