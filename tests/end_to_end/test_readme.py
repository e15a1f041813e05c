"""What the README tells a newcomer to type."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.serving import Lab, free_port, running

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    """Return the README's code blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", README, flags=re.DOTALL | re.MULTILINE)


def run(command: list[str], folder: Path) -> str:
    """Return what a command prints; it runs with this environment's Python first in the path."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        command, cwd=folder, env=os.environ | {"PATH": path}, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_first_two_commands_are_make_targets() -> None:
    commands = [line.split()[:2] for line in blocks("")[0].splitlines()]
    assert commands == [["make", "demo"], ["make", "test"]]
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in [*re.findall(r"`make (\w+)`", README), "demo", "test"]:
        assert re.search(rf"^{target}: setup", makefile, flags=re.MULTILINE), target


def test_the_tour_in_python_names_the_stiffer_element(tmp_path: Path) -> None:
    (script,) = blocks("python")
    (tmp_path / "tour.py").write_text(script, encoding="utf-8")
    *_, last = run([sys.executable, "tour.py"], tmp_path).splitlines()
    verdict = re.fullmatch(
        r"Explained: stiffness error at member 7, factor ([\d.]+)\((\d+)\)\. "
        r"The gap between test and prediction falls from (\S+) to (\S+); random error alone leaves 1\.",
        last,
    )
    assert verdict is not None, last
    factor, digits, before, after = verdict.groups()
    error = int(digits) * 10.0 ** -len(factor.partition(".")[2])
    # five standard errors: one run in two million is further off by chance
    assert abs(float(factor) - 1.3) < 5 * error < 0.01
    assert float(after) < 1.2 < float(before)  # 1 and its scatter; before, the gap is in the thousands
    assert last in README, "the README shows what the tour prints"
    assert (
        tmp_path / "found.png"
    ).stat().st_size > 20_000  # bytes of a picture with curves, and no empty one


def test_the_tour_with_curl_ends_with_a_report(tmp_path: Path) -> None:
    if shutil.which("curl") is None:
        pytest.skip("curl is not installed: the README's tour with curl was not run")
    (script,) = blocks("bash")
    port = free_port()
    data = tmp_path / "data"
    data.mkdir()
    with running("serve", "--port", str(port), data=data), Lab(port) as lab:
        lab.wait_until_up()
        here = script.replace("127.0.0.1:8000", f"127.0.0.1:{port}")
        told = run(["bash", "-euo", "pipefail", "-c", here], tmp_path)
    assert told.splitlines()[-1] == "explained"
    with np.load(tmp_path / "test.npz") as arrays:
        assert arrays["values"].shape == (401, 4, 1)
    assert "extra mass at 15:+Y" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_the_demo_of_another_seed_runs_as_the_readme_has_it(tmp_path: Path) -> None:
    command = re.search(r"`\.venv/bin/(modallab demo --seed \d+)`", README)
    assert command is not None
    told = run([*command[1].split(), "--out", "out"], tmp_path)
    assert "It was named first" in told
    assert (tmp_path / "out" / "demo.html").exists()


def test_what_the_readme_points_to_is_there() -> None:
    for target in re.findall(r"\]\(([^)]+)\)", README):
        assert (ROOT / target).is_file(), target
    assert (ROOT / "docs" / "demo.png").stat().st_size < 200_000  # a picture, not a burden of every clone
