"""Commands on files of other programs, as a user without a service runs them."""

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from modallab_cli.app import app

NASTRAN = Path(__file__).parents[1] / "service" / "interchange" / "nastran"
RIG = {
    "drive": "1:+Z",
    "responses": ["1:+Z", "7:+Z", "35:+Z"],
    "analyser": {"frequency_max": 200.0, "n_lines": 101, "averages": 1},
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory with a log book."""
    (tmp_path / "rig.json").write_text(json.dumps(RIG), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def measure(model: Path, *more: str) -> Result:
    line = ["measure", "--model", str(model), "--rig", "rig.json", "--out", "frf.npz", "--route", "expected"]
    return CliRunner().invoke(app, [*line, *more])


def test_a_nastran_deck_is_measured_and_a_slip_named_on_stderr(folder: Path) -> None:
    done = measure(NASTRAN / "plate.bdf", "--json")
    assert done.exit_code == 0, done.stderr
    reply = json.loads(done.stdout)
    assert (reply["kind"], reply["n_lines"], reply["route"]) == ("inertance", 101, "expected")
    assert not reply.keys() & {"id", "rig_id", "made_from"}, "what ends with the command has no id"
    assert "warning: analyser.averages: with one average" in done.stderr
    assert (folder / "frf.npz").exists()


def test_a_wrong_field_of_a_file_is_told_in_the_words_of_the_service(folder: Path) -> None:
    (folder / "rig.json").write_text(json.dumps(RIG | {"colour": "red"}), encoding="utf-8")
    done = measure(NASTRAN / "plate.bdf")
    assert done.exit_code == 2
    said = done.stderr.splitlines()[-1]
    assert re.match(r"modallab measure: rig\.json: .*colour", said), said
    assert not (folder / "frf.npz").exists()
