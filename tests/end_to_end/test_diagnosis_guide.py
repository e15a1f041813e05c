"""What docs/diagnosis.md tells to type."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from matplotlib import pyplot

DOCS = Path(__file__).parents[2] / "docs"
TEXT = (DOCS / "diagnosis.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    """Return the guide's code blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", TEXT, flags=re.DOTALL | re.MULTILINE)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An empty folder, as a reader has it."""
    return tmp_path_factory.mktemp("guide")


@pytest.fixture(scope="module")
def names(folder: Path) -> dict[str, Any]:
    """What the Python blocks leave behind, run one after the other."""
    pyplot.switch_backend("agg")
    left: dict[str, Any] = {}
    before = Path.cwd()
    os.chdir(folder)
    try:
        for block in blocks("python"):
            exec(block, left)
    finally:
        os.chdir(before)
        pyplot.close("all")
        if "lab" in left:
            left["lab"].close()
    return left


def test_the_hidden_mass_is_named_and_what_was_added_explains_the_test(
    names: dict[str, Any], folder: Path
) -> None:
    (step,) = names["found"].steps
    assert (names["found"].verdict, step.effect.kind, step.effect.at) == ("explained", "extra_mass", "4:+Y")
    mass = step.effect.parameters["mass"]
    # five standard errors: one run in two million is further off by chance
    assert abs(mass.value - names["hidden"]["parameters"]["mass"]) < 5 * mass.standard_error
    assert step.held_out_gap_after < 1.5 < step.held_out_gap_before
    assert names["again"].verdict == "nothing_missing"
    assert "extra mass at 4:+Y" in (folder / "report.html").read_text(encoding="utf-8")


@pytest.mark.usefixtures("names")
def test_the_commands_find_the_same_from_files(folder: Path) -> None:
    (script,) = blocks("bash")
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
