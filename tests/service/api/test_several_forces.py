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
    assert arrays["force_cross_spectra"].shape == (101, 3, 2, 2)


@pytest.fixture(scope="module")
def loaded_beam(service: Any, beam: str) -> str:
    """The beam with 30 g that no model has, driven by two shakers at once."""
    analyser = {
        "frequency_max": 400.0,
        "n_lines": 101,
        "averages": 40,
        "excitation": {"kind": "periodic_random"},
    }
    noise = {"force": 1e-4, "response": 1e-4}
    responses = [f"{node}:+Y" for node in (1, 5, 9, 13, 16, 21)]
    rig = {"drives": ["1:+Y", "16:+Y"], "responses": responses, "analyser": analyser, "noise": noise}
    mass = {"kind": "extra_mass", "at": "9:+Y", "parameters": {"mass": 0.03}}
    body = {"structure_id": beam, "rig_id": service.post("/v1/rigs", rig)["id"], "effects": [mass], "seed": 1}
    return str(service.result_of("/v1/measurements", body))


SUSPECTS = ["extra_mass", "stiffness_error", "gain_error", "exciter_armature"]


def _assert_mass_named(service: Any, diagnosis: str) -> Any:
    found = service.get(f"/v1/diagnoses/{diagnosis}")
    assert found["verdict"] == "explained"
    (step,) = found["steps"]
    assert (step["effect"]["kind"], step["effect"]["at"]) == ("extra_mass", "9:+Y")
    mass = step["effect"]["parameters"]["mass"]
    # four standard errors, one time in 16,000 beyond
    assert abs(mass["value"] - 0.03) < 4 * mass["standard_error"]
    return found


def test_a_diagnosis_of_two_shakers_names_what_is_hidden(service: Any, beam: str, loaded_beam: str) -> None:
    body = {"structure_id": beam, "measurement_id": loaded_beam, "suspects": SUSPECTS}
    diagnosis = service.result_of("/v1/diagnoses", body)
    _assert_mass_named(service, diagnosis)
    curves = _npz(service, f"/v1/diagnoses/{diagnosis}/arrays")
    assert curves["measured"].shape == (101, 6, 2)
    assert curves["force.measured"].shape == (101, 2)
    assert curves["incoherent.measured"].shape == (101, 6)
    report = service.request("GET", f"/v1/diagnoses/{diagnosis}/report").text
    assert "6 responses to simultaneous forces at 1:+Y, 16:+Y" in report
    assert "hammer at" not in report


@pytest.mark.parametrize("path", ["arrays", "frf.uff"])
def test_a_file_of_two_shakers_without_a_rig_is_diagnosed(
    service: Any, beam: str, loaded_beam: str, path: str
) -> None:
    content = service.request("GET", f"/v1/measurements/{loaded_beam}/{path}").content
    name = "test.npz" if path == "arrays" else "test.uff"
    reply = service.request(
        "POST", "/v1/measurements/import", files=[("file", (name, content))], data={"averages": "40"}
    )
    assert reply.status_code == 201, reply.text
    imported = reply.json()
    assert imported["rig"]["exciter"]["kind"] == "shaker"
    assert imported["inputs"] == ["1:+Y", "16:+Y"]
    body = {"structure_id": beam, "measurement_id": imported["id"], "suspects": SUSPECTS}
    found = _assert_mass_named(service, service.result_of("/v1/diagnoses", body))
    # a universal file has no cross spectra
    assert any("uncorrelated" in note for note in found["notes"]) is (path == "frf.uff")


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


def _npz(service: Any, path: str) -> Any:
    return np.load(io.BytesIO(service.request("GET", path).content))


@pytest.fixture(scope="module")
def driven_twice(service: Any, beam: str) -> str:
    """The beam driven by two shakers at once, periodic random."""
    rig = {**RIG, "analyser": {"n_lines": 401, "averages": 40}, "exciter": {"kind": "shaker"}}
    id = service.post("/v1/rigs", rig)["id"]
    return str(
        service.result_of(
            "/v1/measurements", {"structure_id": beam, "rig_id": id, "route": "sampled", "seed": 1}
        )
    )


@pytest.mark.parametrize("method", ["poly_reference_lscf", "lscf", "dobson"])
def test_modes_are_read_from_all_drive_points_together(
    service: Any, beam: str, driven_twice: str, method: str
) -> None:
    body = {"measurement_id": driven_twice, "method": method}
    id = service.result_of("/v1/modal-models", body)
    model = service.get(f"/v1/modal-models/{id}")
    assert (model["drive"], model["references"]) == (None, ["1:+Y", "16:+Y"])
    assert model["dofs"] == ["1:+Y", "7:+Y", "16:+Y"]
    assert model["frfs"][:2] == ["1:+Y / 1:+Y", "1:+Y / 16:+Y"]
    assert list(model["resynthesis_error"]) == model["frfs"]
    assert model["normalisation"] == "mass"
    assert model["choices"]["references"].startswith("1:+Y, 16:+Y: ")
    exact = service.get(f"/v1/structures/{beam}/modes?count=8")
    found = [mode["frequency"] for mode in model["modes"]]
    # noise of 1e-3 in 40 averages tells frequencies to some 1e-5 where nothing is biased
    np.testing.assert_allclose(found, exact["frequencies"], rtol=2e-4)
    arrays = _npz(service, f"/v1/modal-models/{id}/arrays")
    assert arrays["shapes"].shape == (3, 8)
    assert arrays["modal_constants"].shape == (8, 6)
    made, test = (
        _npz(service, path)
        for path in (f"/v1/modal-models/{id}/frf", f"/v1/measurements/{driven_twice}/arrays")
    )
    assert made["values"].shape[1:] == test["values"].shape[1:] == (3, 2)
    assert made["inputs"].tolist() == ["1:+Y", "16:+Y"]


def test_a_fit_of_several_references_is_asked_for_by_both_points(service: Any, driven_twice: str) -> None:
    body = {"measurement_id": driven_twice, "method": "dobson", "n_modes": 3}
    id = service.result_of("/v1/modal-models", body)
    asked = {"mode": 2, "response": "7:+Y", "reference": "16:+Y"}
    fit = service.get(f"/v1/modal-models/{id}/fits", params=asked)
    constant = _npz(service, f"/v1/modal-models/{id}/arrays")["modal_constants"][1, 3]  # 7:+Y / 16:+Y
    assert complex(*fit["modal_constant"]) == pytest.approx(constant, rel=1e-3)  # fitted once more
    for reference, value in ((None, None), ("3:+Y", "3:+Y")):
        params = {k: v for k, v in {**asked, "reference": reference}.items() if v is not None}
        reply = service.request("GET", f"/v1/modal-models/{id}/fits", params=params)
        assert reply.status_code == 422
        context = reply.json()["context"]
        assert (context["field"], context["value"]) == ("reference", value)
        assert context["allowed"] == ["1:+Y", "16:+Y"]


SENSORS = [f"{n}:+Y" for n in range(1, 22, 2)]
SEVERAL_INPUTS: dict[str, dict[str, Any]] = {
    "two shakers": {"drives": ["1:+Y", "15:+Y"], "responses": SENSORS},
    "roving hammer": {"drives": SENSORS, "responses": ["1:+Y", "15:+Y"], "exciter": {"kind": "hammer"}},
}


@pytest.fixture(scope="module", params=SEVERAL_INPUTS)
def test_of_weak_member(service: Any, beam: str, request: pytest.FixtureRequest) -> str:
    analyser = {"frequency_max": 1600.0, "n_lines": 161, "excitation": {"kind": "periodic_random"}}
    noise = {"force": 0.0, "response": 1e-4}
    rig: dict[str, Any] = {**SEVERAL_INPUTS[request.param], "analyser": analyser, "noise": noise}
    changes: list[dict[str, Any]] = [{"members": [11], "property": "modulus", "factor": 1.8}]
    weak = service.post(f"/v1/structures/{beam}/changes", {"changes": changes})["id"]
    body = {"structure_id": weak, "rig_id": service.post("/v1/rigs", rig)["id"], "route": "drawn", "seed": 2}
    return str(service.result_of("/v1/measurements", body))


def test_an_update_on_frfs_to_several_inputs_fits_within_their_random_errors(
    service: Any, beam: str, test_of_weak_member: str
) -> None:
    made_from = {"structure_id": beam, "measurement_id": test_of_weak_member}
    parameterisation = {"macros": "each", "parts": ["stiffness"]}
    body = {**made_from, "method": "frf_residual", "parameterisation": parameterisation}
    found = service.get(f"/v1/updates/{service.result_of('/v1/updates', body)}")
    assert found["suspected"]["stiffness"] == [11]
    fit = found["responses"]
    assert len(fit["outputs"]) * len(fit["inputs"]) == 22
    # random errors that were too small by a root of two would leave 2
    assert abs(fit["after"] - 1) < 0.2


def test_frfs_to_several_inputs_are_correlated_input_by_input(
    service: Any, beam: str, test_of_weak_member: str
) -> None:
    modes = service.result_of("/v1/modal-models", {"measurement_id": test_of_weak_member, "n_modes": 3})
    body = {"structure_id": beam, "measurement_id": test_of_weak_member, "modal_model_id": modes}
    id = service.post("/v1/correlations", body)["id"]
    arrays = _npz(service, f"/v1/correlations/{id}/arrays")
    n_out, n_in = len(arrays["outputs"]), len(arrays["inputs"])
    assert n_out * n_in == 22
    assert arrays["frac"].shape == (n_out, n_in)
    assert arrays["fdac"].shape[0] == n_in
    # a member that is 1.8 times as stiff moves all modes: no FRF is like another, none is unlike itself
    assert (arrays["frac"] > 0.0).all()
    assert (arrays["frac"] < 0.999).all()
