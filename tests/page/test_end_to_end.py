"""A student's way through the page in a browser, by the keyboard: rig, measure, extract, correlate, diagnose.

The script looks, too, whether axe-core finds a serious violation in any view, light or dark, whether a view
is wider than 400 px, and whether the browser complains or asks another host.
"""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.page.conftest import SOURCES

STEPS = (
    *("first load", "rig", "measure", "extract", "correlate"),
    *("diagnose", "own files", "shared address", "errors", "reference"),
)


@pytest.fixture(scope="module")
def steps(node: str, chromium: str, address: str, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What the script says of each step."""
    pictures = Path(os.environ.get("PAGE_PICTURES") or tmp_path_factory.mktemp("pictures"))
    done = subprocess.run(
        [node, "e2e/path.mjs", address, str(pictures)],
        cwd=SOURCES,
        env=os.environ | {"CHROMIUM": chromium},
        capture_output=True,
        text=True,
    )
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert lines, done.stderr
    return {line["name"]: line for line in lines}


@pytest.mark.parametrize("name", STEPS)
def test_a_step_of_a_student(steps: dict[str, Any], name: str) -> None:
    assert name in steps, "an earlier step failed"
    assert "fault" not in steps[name], steps[name]["fault"]


def test_the_diagnosis_names_the_hidden_effect(steps: dict[str, Any]) -> None:
    assert steps["diagnose"]["verdict"] == "Explained. Missing effect: extra mass at 9:+Y."


@pytest.mark.parametrize("name", ["measure", "extract"])
def test_what_is_copied_as_python_runs(steps: dict[str, Any], name: str) -> None:
    done = subprocess.run([sys.executable, "-c", steps[name]["python"]], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    expected = {"measure": "(401,) (401, 11, 1)", "extract": "frequency"}[name]
    assert expected in done.stdout
