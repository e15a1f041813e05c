"""The client alone: its command line works against a lab elsewhere, and names what is not installed."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.bodies import free_beam
from tests.serving import Lab, free_port, running

# What `pip install modallab` does not bring; matplotlib stays, to see the pictures.
ABSENT = "fastapi starlette pydantic scipy sqlalchemy dbos alembic uvicorn h5py meshio pyuff typer rich"
SCRIPT = f"""
import sys

class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {ABSENT.split()!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Refuse())
import importlib.util
found = importlib.util.find_spec
importlib.util.find_spec = lambda name, *more: None if name in {ABSENT.split()!r} else found(name, *more)
from modallab.__main__ import main
main()
"""
RIG = {
    "drive": "1:+Y",
    "responses": ["1:+Y", "4:+Y", "7:+Y"],
    "noise": {"force": 1e-4, "response": 1e-4},
    "analyser": {"frequency_max": 400.0, "n_lines": 161},
}
HIDDEN = '{"kind":"extra_mass","at":"4:+Y","parameters":{"mass":0.03}}'
FILES = "--model model.json --measured test.uff --rig rig.json"


def modallab(*arguments: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    """Return what a command did where the packages of the service are not installed."""
    return subprocess.run(
        [sys.executable, "-c", SCRIPT, *arguments],
        cwd=folder,
        env=os.environ | {"COLUMNS": "200"},
        capture_output=True,
        text=True,
        timeout=120,
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a model and a log book."""
    place = tmp_path_factory.mktemp("files")
    (place / "model.json").write_text(json.dumps(free_beam()), encoding="utf-8")
    (place / "rig.json").write_text(json.dumps(RIG), encoding="utf-8")
    (place / "frf.uff").write_text("", encoding="utf-8")
    return place


@pytest.fixture(scope="module")
def url(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a lab."""
    port = free_port()
    with running("serve", "--port", str(port), data=tmp_path_factory.mktemp("data")), Lab(port) as lab:
        lab.wait_until_up()
        yield f"http://127.0.0.1:{port}"


@pytest.mark.parametrize("option", ["--help", "--version"])
def test_help_and_version_need_nothing_else(folder: Path, option: str) -> None:
    done = modallab(option, folder=folder)
    assert done.returncode == 0, done.stderr
    assert "modallab" in done.stdout


@pytest.mark.parametrize(
    "command",
    [
        "measure --model model.json --rig rig.json --out a.npz",
        "extract frf.uff",
        "update --model model.json --modes frf.uff",
        "diagnose --model model.json --measured frf.uff --rig rig.json",
        "convert frf.uff a.npz",
        "plot frf.uff a.png",
        "openapi",
        "serve --port 80",
        "demo",
    ],
)
def test_a_command_that_needs_more_says_in_one_line_which_extra(folder: Path, command: str) -> None:
    done = modallab(*command.split(), folder=folder)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"modallab {command.split()[0]}: ")
    assert "pip install 'modallab[service]'" in line


def test_a_lab_elsewhere_does_the_work(folder: Path, url: str) -> None:
    steps = {
        "measure": f"--model model.json --rig rig.json --out test.uff --plot m.svg --effect {HIDDEN}",
        "convert": "test.uff test.npz --plot c.svg",
        "extract": "test.npz --rig rig.json --n-modes 3 --out modes.json --plot e.svg",
        "update": "--model model.json --modes modes.json --part mass --plot u.svg --json",
        "diagnose": f"{FILES} --suspect extra_mass --report r.html --title T",
    }
    said = {}
    for name, arguments in steps.items():
        done = modallab(name, *arguments.split(), "--server", url, folder=folder)
        assert done.returncode == 0, (name, done.stderr)
        said[name] = done.stdout
    assert said["measure"].startswith("test.uff: inertance of 3 responses and 1 force")
    assert "3 modes from" in said["extract"]
    assert json.loads(said["update"])["kind"] == "iterative"
    assert "Explained: extra mass at 4:+Y, mass 0.030" in said["diagnose"]
    assert "T</p>" in (folder / "r.html").read_text(encoding="utf-8")
    for picture in ("m.svg", "c.svg", "e.svg", "u.svg"):
        assert "<svg" in (folder / picture).read_text(encoding="utf-8")[:2000], picture


def test_what_a_lab_elsewhere_keeps_goes_through_a_file(folder: Path, url: str) -> None:
    for arguments, begin in (
        ("export project.zip", "project.zip: "),
        ("import project.zip", "project.zip: "),
        ("trash list", ""),
    ):
        done = modallab(*arguments.split(), "--server", url, folder=folder)
        assert done.returncode == 0, (arguments, done.stderr)
        assert done.stdout.startswith(begin)
