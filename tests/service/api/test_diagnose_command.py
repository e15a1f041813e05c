"""`modallab diagnose`: files in, words out."""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from pydantic import TypeAdapter

from modallab.api.rigs.schemas import RigIn
from modallab.api.structures.schemas import StructureIn
from modallab.core.dof import Dof
from modallab.core.place import EffectSpec
from modallab.interchange import frf_text, hdf5, uff
from modallab.interchange.settings import FRF_TEXT_FILE
from modallab.rig.effect import build
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.store.codec import arrays_of
from modallab.store.npz import pack
from modallab_cli.app import app
from tests.bodies import free_beam

MODEL: Mapping[str, Any] = free_beam()
RIG: Mapping[str, Any] = {
    "drive": "1:+Y",
    "responses": [f"{n}:+Y" for n in (1, 2, 4, 5, 7, 9)],
    "noise": {"force": 1e-4, "response": 1e-4},
    "analyser": {"frequency_max": 400.0, "n_lines": 161},
}
MASS = 0.03  # kg at node 4, hidden
FEW = ("--suspects", "extra_mass", "--suspects", "gain_error")


@pytest.fixture(scope="module")
def test_of_the_beam() -> Measurement:
    """A measurement of the beam with a mass that neither file tells of."""
    structure = TypeAdapter[Any](StructureIn).validate_python(MODEL).to_domain()
    setup = TypeAdapter(RigIn).validate_python(RIG).to_domain()
    hidden = build(EffectSpec("extra_mass", Dof(4, "Y"), {"mass": MASS}))
    return measure(structure, setup, [hidden], route=Route.DRAWN, rng=np.random.default_rng(1))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, test_of_the_beam: Measurement) -> Path:
    """A folder with model, log book, and the measurement in every format."""
    place = tmp_path_factory.mktemp("files")
    (place / "model.json").write_text(json.dumps(MODEL), encoding="utf-8")
    (place / "rig.json").write_text(json.dumps(RIG), encoding="utf-8")
    (place / "frf.uff").write_bytes(uff.write(test_of_the_beam))
    (place / "frf.h5").write_bytes(hdf5.write(test_of_the_beam))
    (place / "frf.frf").write_bytes(frf_text.write(test_of_the_beam, FRF_TEXT_FILE.all_decimals))
    (place / "frf.npz").write_bytes(pack(arrays_of(test_of_the_beam)))
    return place


def run(folder: Path, *more: str, measured: str = "frf.uff", model: str = "model.json") -> Result:
    """Return what the command did."""
    files = ["--model", folder / model, "--measured", folder / measured, "--rig", folder / "rig.json"]
    return CliRunner().invoke(app, ["diagnose", *map(str, files), *more], env={"COLUMNS": "200"})


def test_a_hidden_mass_is_told_in_plain_words_with_its_report(folder: Path, tmp_path: Path) -> None:
    page = tmp_path / "out.html"
    done = run(folder, *FEW, "--report", str(page))
    assert done.exit_code == 0, done.stderr
    assert "Missing effect: extra mass at 4:+Y." in done.stdout
    mass = re.search(
        r"^missing 1  extra mass at 4:\+Y: mass ([\d.]+) ± ([\d.]+) kg$", done.stdout, re.MULTILINE
    )
    assert mass is not None, done.stdout
    # five standard errors: one run in two million is further off by chance
    assert abs(float(mass[1]) - MASS) < 5 * float(mass[2])
    assert "on the held-out FRFs" in done.stdout
    assert str(page) in done.stdout
    assert "<h1>Explained" in page.read_text(encoding="utf-8")
    # how far it was is told apart from what it found, and rises
    shares = [int(share) for share in re.findall(r"^ *(\d+)%", done.stderr, flags=re.MULTILINE)]
    assert len(shares) > 3
    assert shares == sorted(shares)
    assert "%  " not in done.stdout
    assert "modallab" in page.read_text(encoding="utf-8").split('<div class="call">')[1]


@pytest.mark.parametrize("measured", ["frf.uff", "frf.h5", "frf.npz", "frf.frf"])
def test_every_format_the_service_reads_gives_the_mass_as_json(folder: Path, measured: str) -> None:
    done = run(folder, "--suspects", "extra_mass", "--json", measured=measured)
    assert done.exit_code == 0, done.stderr
    found = json.loads(done.stdout)
    (step,) = found["steps"]
    mass = step["effect"]["parameters"]["mass"]
    # five standard errors: one run in two million is further off by chance
    assert abs(mass["value"] - MASS) < 5 * mass["standard_error"]
    (added,) = found["added_effects"]["model"]
    assert added == {"kind": "extra_mass", "at": "4:+Y", "parameters": {"mass": mass["value"]}}
    assert found["added_effects"]["rig"] == []


def test_what_the_result_names_can_be_put_into_the_model_and_closes_the_gap(folder: Path) -> None:
    found = json.loads(run(folder, "--suspects", "extra_mass", "--json").stdout)
    model = dict(MODEL) | {"effects": found["added_effects"]["model"]}
    (folder / "better.json").write_text(json.dumps(model), encoding="utf-8")
    again = json.loads(run(folder, *FEW, "--json", model="better.json").stdout)
    assert again["verdict"] == "nothing_missing"


def test_a_response_to_hold_out_and_one_to_predict(folder: Path, tmp_path: Path) -> None:
    page = tmp_path / "out.html"
    options = ("--hold-out", "7:+Y", "--hold-out", "3:+Y", "--hold-out", "0", "--report", str(page))
    assert run(folder, *FEW, *options).exit_code == 0
    words = page.read_text(encoding="utf-8")
    assert "Held out of every fit: 7:+Y." in words
    assert "Response 3:+Y / 1:+Y, not measured" in words


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--suspects", "gremlin"), "no effect called 'gremlin'"),
        (("--hold-out", "0.9"), "at most half of the FRFs can be held out"),
        (("--hold-out", "99:+Y"), "99"),
        (("--hold-out", "0.2", "--hold-out", "0.3"), "one fraction"),
        (("--hold-out", "left end"), "'left end' is not a degree of freedom"),
        (("--tolerance", "modulus"), "is not name=value"),
        (("--tolerance", "gremlin=0.1"), "tolerances"),
        (("--max-effects", "0"), "max_effects: Input should be greater than or equal to 1"),
        (("--seed", "-1"), "seed: Input should be greater than or equal to 0"),
    ],
)
def test_an_option_without_sense_ends_with_2_and_says_why(
    folder: Path, options: tuple[str, ...], words: str
) -> None:
    done = run(folder, *options)
    assert done.exit_code == 2
    assert words in done.stderr
    assert done.stdout == ""


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("model.json", "{", "model.json: not JSON"),
        (
            "model.json",
            json.dumps({**MODEL, "lenght": 1.0}),
            "model.json: beam.lenght: there is no such field; did you mean `length`?",
        ),
        ("model.json", json.dumps({**MODEL, "n_elements": 4}), "7"),  # node 7 is measured
        ("rig.json", json.dumps({**RIG, "drive": "2:+Y"}), "frf.uff: the file drives elsewhere than the rig"),
        ("rig.json", json.dumps({**RIG, "drive": None}), "rig.json: a rig drives at one DoF or at several"),
        ("frf.uff", "what is this", "frf.uff: the file holds no rows of numbers"),
    ],
)
def test_a_file_at_fault_is_named(folder: Path, tmp_path: Path, name: str, content: str, words: str) -> None:
    for path in ("model.json", "rig.json", "frf.uff"):
        (tmp_path / path).write_bytes((folder / path).read_bytes())
    (tmp_path / name).write_text(content, encoding="utf-8")
    done = run(tmp_path, *FEW)
    assert done.exit_code == 2
    assert words in done.stderr


def test_a_missing_file_is_named(folder: Path) -> None:
    done = run(folder, measured="none.uff")
    assert done.exit_code == 2
    assert "none.uff" in done.stderr


def test_without_coherence_the_random_error_is_estimated_or_stated(
    folder: Path, test_of_the_beam: Measurement
) -> None:
    bare = {name: array for name, array in arrays_of(test_of_the_beam).items() if name != "coherence"}
    (folder / "bare.npz").write_bytes(pack(bare))
    for stated in ((), ("--noise-floor", "0.02")):
        done = run(folder, *FEW, *stated, measured="bare.npz")
        assert done.exit_code == 0, done.stderr
    assert "Missing effect: extra mass at 4:+Y." in done.stdout
    assert "no usable coherence" in done.stdout


def test_a_slip_in_a_file_is_named_on_stderr(folder: Path) -> None:
    once = {**RIG, "analyser": RIG["analyser"] | {"averages": 1}}
    (folder / "once.json").write_text(json.dumps(once), encoding="utf-8")
    done = run(folder, *FEW, "--rig", str(folder / "once.json"), "--noise-floor", "1e-3", "--json")
    assert done.exit_code == 0, done.stderr
    assert "warning: analyser.averages: with one average the coherence is 1" in done.stderr
    assert "warning" not in done.stdout
