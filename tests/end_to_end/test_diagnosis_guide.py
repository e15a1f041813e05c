"""What docs/diagnosis.md tells to type."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.pages import DOCS, blocks, run_page

TEXT = (DOCS / "diagnosis.md").read_text(encoding="utf-8")


def check(names: dict[str, Any]) -> None:
    """Compare what the blocks leave behind with what the page says."""
    (step,) = names["found"].steps
    assert (names["found"].verdict, step.effect.kind, step.effect.at) == ("explained", "extra_mass", "4:+Y")
    mass = step.effect.parameters["mass"]
    # five standard errors: one run in two million is further off by chance
    assert abs(mass.value - names["hidden"]["parameters"]["mass"]) < 5 * mass.standard_error
    assert step.held_out_gap_after < 1.5 < step.held_out_gap_before
    assert names["again"].verdict == "nothing_missing"
    assert "extra mass at 4:+Y" in Path("report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that was empty, as a reader has it, before the Python blocks ran in it."""
    place = tmp_path_factory.mktemp("guide")
    run_page("diagnosis.md", place, check)
    return place


def test_blocks_and_commands_name_the_hidden_mass(folder: Path) -> None:
    (script,) = blocks("diagnosis.md", "bash")
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", script],
        cwd=folder,
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert "Missing effect: extra mass at 4:+Y." in done.stdout
    assert (folder / "out.html").stat().st_size < 1_000_000
    found = json.loads((folder / "found.json").read_text(encoding="utf-8"))
    (added,) = found["added_effects"]["model"]
    assert (added["kind"], added["at"]) == ("extra_mass", "4:+Y")


def test_the_guide_names_every_option_verdict_and_tolerance() -> None:
    from modallab.diagnosis.result import Verdict

    told = subprocess.run(
        [sys.executable, "-m", "modallab", "diagnose", "--help"],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"COLUMNS": "200", "NO_COLOR": "1"},
    ).stdout
    options = set(re.findall(r"--[a-z][a-z-]+", told)) - {"--help"}
    assert options
    for name in [*options, *Verdict]:
        assert name in TEXT, name


def test_what_the_guide_points_to_is_there() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", TEXT):
        assert (DOCS / target).is_file(), target
    headings = re.findall(r"^## (.*)$", TEXT, flags=re.MULTILINE)
    anchors = {re.sub(r"[^a-z0-9 -]", "", one.lower()).replace(" ", "-") for one in headings}
    for anchor in re.findall(r"\]\(#([^)]+)\)", TEXT):
        assert anchor in anchors, anchor
