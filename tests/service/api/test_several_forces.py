"""Several exciters at once, and the converter's settings, over HTTP."""

import io
from typing import Any

import numpy as np
import pytest

RIG: dict[str, Any] = {
    "drives": ["1:+Y", "16:+Y"],
    "responses": ["1:+Y", "7:+Y", "16:+Y"],
    "exciter": {"kind": "shaker", "armature_mass": 0.02},
    "analyser": {"n_lines": 101, "averages": 40, "bits": 12, "range_factor": 5.0},
    "noise": {"force": 1e-3, "response": 1e-3},
}


def test_two_shakers_measure_a_matrix_of_frfs_and_say_how_well_they_are_told_apart(
    service: Any, beam: str
) -> None:
    rig = service.post("/v1/rigs", RIG)["id"]
    shown = service.get(f"/v1/rigs/{rig}")
    assert (shown["analyser"]["bits"], shown["analyser"]["range_factor"]) == (12, 5.0)
    body = {"structure_id": beam, "rig_id": rig, "route": "sampled", "seed": 1}
    measured = service.result_of("/v1/measurements", body)
    arrays = np.load(io.BytesIO(service.request("GET", f"/v1/measurements/{measured}/arrays").content))
    assert arrays["values"].shape == (101, 3, 2)
    assert arrays["coherence"].shape == (101, 3)
    assert arrays["input_condition"].shape == (101,)
    assert (arrays["input_condition"] >= 1).all()
    problem = service.post("/v1/diagnoses", {"structure_id": beam, "measurement_id": measured}, status=422)
    assert problem["context"]["field"] == "inputs"


@pytest.mark.parametrize(
    ("field", "changed"),
    [
        ("estimator", {"estimator": "h2"}),
        ("estimator", {"estimator": "hv"}),
        ("averages", {"averages": 1}),
        ("bits", {"bits": 2}),
        ("bits", {"bits": 64}),
        ("range_factor", {"range_factor": 0.0}),
        ("range_factor", {"bits": None, "range_factor": 101.0}),
        ("bits", {"bits": 4, "range_factor": 20.0}),
    ],
)
def test_what_cannot_be_measured_so_is_refused_by_name(
    service: Any, field: str, changed: dict[str, Any]
) -> None:
    problem = service.post("/v1/rigs", {**RIG, "analyser": {**RIG["analyser"], **changed}}, status=422)
    assert problem["context"]["field"] == field


def test_bits_are_a_whole_number(service: Any) -> None:
    problem = service.post("/v1/rigs", {**RIG, "analyser": {"bits": 12.5}}, status=422)
    assert "bits" in str(problem)
