"""The unknown effect of a diagnosis is adopted over HTTP; one without is refused by name."""

import io
from typing import Any

import numpy as np
import pytest

from modallab_client import ModalLab
from modallab_client.errors import InvalidInputError

BEAM: dict[str, Any] = {
    "kind": "beam",
    "length": 1.2,
    "n_elements": 8,
    "section": {"area": 5e-4, "second_moment": 4.1667e-9},
    "material": {"modulus": 2.09e11, "density": 7800.0},
    "damping": {"law": "structural", "stiffness_coefficient": 0.008},
}
POINTS = [f"{node}:+Y" for node in (1, 2, 4, 5, 7, 9)]


def _diagnosis(lab: ModalLab, suspects: list[str]) -> tuple[Any, str]:
    beam = lab.structures.create(**BEAM)
    rig = lab.rigs.create(
        drive="1:+Y",
        responses=POINTS,
        noise={"force": 1e-3, "response": 1e-3},
        analyser={"frequency_max": 400.0, "n_lines": 161},
    )
    hidden = {"kind": "ground_spring", "at": "5:+Y", "parameters": {"stiffness": 2e4}}
    test = lab.measurements.start(beam.id, rig.id, effects=[hidden], route="drawn", seed=1).result()
    return lab.diagnoses.start(beam.id, test.id, suspects=suspects).result(), test.id


def test_the_model_with_the_adopted_effect_explains_the_test() -> None:
    with ModalLab.embedded() as lab:
        found, test = _diagnosis(lab, ["polarity"])
        assert (found.unknown.at, found.unknown.curve_model) == ("5:+Y", "spring")
        arrays = np.load(io.BytesIO(lab.request("GET", f"/v1/diagnoses/{found.id}/arrays")))
        first, last = found.unknown.curve[0], found.unknown.curve[-1]
        assert arrays["unknown.freq"].tolist() == [point.frequency for point in found.unknown.curve]
        assert arrays["unknown.value"][0] == complex(first.real, first.imaginary)
        assert arrays["unknown.error"][-1] == last.standard_error
        stiffness = found.unknown.parameters["stiffness"].value
        assert set(arrays["unknown.model"][1:]) == {stiffness}  # of a spring; none at 0 Hz
        adopted = lab.diagnoses.adopt(found.id)
        assert adopted.kind == "tabulated_stiffness"
        assert lab.diagnoses.start(adopted.structure_id, test).result().verdict == "nothing_missing"


def test_a_diagnosis_without_an_unknown_effect_has_nothing_to_adopt() -> None:
    with ModalLab.embedded() as lab:
        found, _ = _diagnosis(lab, ["ground_spring"])
        with pytest.raises(InvalidInputError, match="no unknown effect"):
            lab.diagnoses.adopt(found.id)
