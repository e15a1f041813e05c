"""A diagnosis of a roving hammer's test over HTTP: effect, arrays and report by response and drive point."""

import io
from typing import Any

import numpy as np
import pytest

from modallab_client.methods.diagnoses import diagnosis_curves

STRUCK = ["1:+Y", "5:+Y", "9:+Y", "14:+Y", "21:+Y"]
REFERENCES = ["1:+Y", "9:+Y"]


@pytest.fixture(scope="module")
def diagnosed(service: Any, beam: str) -> Any:
    """The beam with an element of four fifths of its stiffness, struck at five points."""
    rig = {
        "drives": STRUCK,
        "responses": REFERENCES,
        "exciter": {"kind": "hammer"},
        "noise": {"force": 1e-4, "response": 1e-4},
        "analyser": {"frequency_max": 400.0, "n_lines": 101, "averages": 30},
    }
    soft = {"kind": "stiffness_error", "at": {"members": [6]}, "parameters": {"factor": 0.8}}
    body = {"structure_id": beam, "rig_id": service.post("/v1/rigs", rig)["id"], "effects": [soft]}
    measured = service.result_of("/v1/measurements", body | {"route": "drawn", "seed": 3})
    suspects = ["stiffness_error", "extra_mass"]
    asked = {"structure_id": beam, "measurement_id": measured, "suspects": suspects, "bands": [[20, 380]]}
    found = service.result_of("/v1/diagnoses", asked)
    return service.get(f"/v1/diagnoses/{found}")


def test_the_wrong_element_is_named(diagnosed: Any) -> None:
    assert diagnosed["verdict"] == "explained"
    (step,) = diagnosed["steps"]
    assert (step["effect"]["kind"], step["effect"]["at"]) == ("stiffness_error", {"members": [6]})
    assert any("reciprocity tested with 1 pair of" in note for note in diagnosed["notes"])
    pairs = {(misfit["dof"], misfit["drive"]) for misfit in diagnosed["located"]["responses"]}
    assert pairs == {(response, drive) for response in REFERENCES for drive in STRUCK}


def test_the_arrays_are_by_response_and_drive_point(service: Any, diagnosed: Any) -> None:
    reply = service.request("GET", f"/v1/diagnoses/{diagnosed['id']}/arrays")
    curves = diagnosis_curves(np.load(io.BytesIO(reply.content)))
    assert curves.measured.shape == (len(curves.freq), 2, 5)
    assert curves.held_out.shape == (2, 5)
    assert curves.held_out.sum() == 2  # a quarter of ten, rounded down
    frfs = curves.by_frf()
    assert frfs.names[:3] == ("1:+Y / 1:+Y", "9:+Y / 1:+Y", "1:+Y / 5:+Y")
    np.testing.assert_array_equal(frfs.measured[:, 2], curves.measured[:, 0, 1])
    plain = service.request(
        "GET", f"/v1/diagnoses/{diagnosed['id']}/arrays", headers={"Accept": "application/json"}
    )
    assert np.array(plain.json()["held_out"]).shape == (2, 5)


def test_the_report_names_each_frf(service: Any, diagnosed: Any) -> None:
    page = service.request("GET", f"/v1/diagnoses/{diagnosed['id']}/report").text
    assert "a hammer at 5 points" in page
    assert "9:+Y / 5:+Y" in page
