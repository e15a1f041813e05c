"""What docs/own-data.md tells to type."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modallab.api.rigs.schemas import RigIn
from tests.pages import DOCS, Check, blocks, outcomes

ROOT = DOCS.parent
TEXT = (DOCS / "own-data.md").read_text(encoding="utf-8")


def texts_matlab_and_universal_file_hold_the_same_test(names: dict[str, Any]) -> None:
    test = names["test"]
    assert test.values.shape == (1141, 1, 11)
    assert {a.quantity for a in test.assumed} == {"averages", "exciter", "window", "excitation"}
    size = np.abs(test.values).max()
    # six digits of a text, seven of single precision
    np.testing.assert_allclose(names["from_matlab"].values, test.values, atol=1e-5 * size)
    assert names["from_universal"].inputs != test.inputs  # files come in the order of their names
    assert set(names["from_universal"].inputs) == set(test.inputs)


def the_modes_are_those_that_the_guide_names(names: dict[str, Any]) -> None:
    modes = names["modes"]
    # the guide's digits
    assert [round(f, 1) for f in modes.frequencies] == [26.8, 76.9, 148.2, 247.6]
    np.testing.assert_allclose(modes.loss_factors, 0.02, rtol=0.025)  # the guide's two digits


def update_and_diagnosis_name_the_weak_element(names: dict[str, Any]) -> None:
    assert len(re.findall(r"0\.99\d\d$", names["found"].table(), flags=re.MULTILINE)) == 4
    (row,) = [line.split() for line in names["update"].table().splitlines() if line.split()[1] == "6"]
    assert float(row[2]) == pytest.approx(0.7, abs=0.005)  # the guide's two digits
    (step,) = names["diagnosis"].steps
    assert (names["diagnosis"].verdict, step.effect.kind) == ("explained", "stiffness_error")
    factor = step.effect.parameters["factor"]
    # five standard errors, of which the coherence's own digits are a part
    assert abs(factor.value - 0.7) < 5 * factor.standard_error + 1e-4
    assert Path("report.html").stat().st_size > 10_000


CHECKS = [
    texts_matlab_and_universal_file_hold_the_same_test,
    the_modes_are_those_that_the_guide_names,
    update_and_diagnosis_name_the_weak_element,
]


@pytest.fixture(scope="module")
def found_wrong(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What each check found wrong after the page's commands and blocks ran in an empty folder."""
    folder = tmp_path_factory.mktemp("guide")
    found = [str(Path(sys.executable).parent), os.environ["PATH"]]
    paths = [str(ROOT), os.environ.get("PYTHONPATH", "")]
    environment = os.environ | {"PATH": os.pathsep.join(found), "PYTHONPATH": os.pathsep.join(paths)}
    for script in blocks("own-data.md", "bash"):
        done = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", script],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=300,
        )
        assert done.returncode == 0, done.stderr
    return outcomes("own-data.md", folder, CHECKS)


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_the_examples_give_what_the_page_says(check: Check, found_wrong: dict[str, str]) -> None:
    assert not found_wrong[check.__name__], found_wrong[check.__name__]


def test_the_log_book_of_the_guide_is_a_rig() -> None:
    (body,) = blocks("own-data.md", "json")
    assert RigIn.model_validate(json.loads(body)).to_domain().analyser.window_end == 0.1


def test_what_the_guide_points_to_is_there() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", TEXT):
        assert (DOCS / target).is_file(), target
