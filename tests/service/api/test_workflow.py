"""The main job over HTTP: measure, read modes, compare, correct the model, find what it lacks."""

import io
from typing import Any

import numpy as np
import pytest


def npz(service: Any, path: str) -> Any:
    reply = service.request("GET", path)
    assert reply.status_code == 200, reply.text
    assert reply.headers["content-type"] == "application/octet-stream"
    return np.load(io.BytesIO(reply.content))


@pytest.fixture(scope="module")
def truth(service: Any, beam: str) -> str:
    """The beam with a stiffer member 7."""
    changes = [{"members": [7], "property": "modulus", "factor": 1.3}]
    return str(service.post(f"/v1/structures/{beam}/changes", {"changes": changes})["id"])


@pytest.fixture(scope="module")
def measured_id(service: Any, truth: str, rig: str) -> str:
    """A test of the stiffened beam."""
    body = {"structure_id": truth, "rig_id": rig, "route": "drawn", "seed": 1}
    return str(service.result_of("/v1/measurements", body))


@pytest.fixture(scope="module")
def modes(service: Any, measured_id: str) -> str:
    """The modes that the test shows."""
    body = {"measurement_id": measured_id, "method": "dobson", "n_modes": 8}
    return str(service.result_of("/v1/modal-models", body))


def test_a_measurement_shows_its_log_book_and_not_its_truth(
    service: Any, measured_id: str, truth: str, rig: str
) -> None:
    shown = service.get(f"/v1/measurements/{measured_id}")
    assert (shown["rig_id"], shown["seed"], shown["kind"]) == (rig, 1, "inertance")
    assert shown["rig"]["noise"] == {"force": 1e-3, "response": 1e-3}
    assert truth not in str(shown)
    assert service.get(f"/v1/measurements/{measured_id}/truth") == {"structure_id": truth, "effects": []}


def test_the_arrays_have_the_shapes_of_the_contract(service: Any, measured_id: str) -> None:
    arrays = npz(service, f"/v1/measurements/{measured_id}/arrays")
    assert arrays["freq"].shape == (401,)
    assert arrays["values"].shape == (401, 6, 1)
    assert arrays["coherence"].shape == (401, 6)
    assert arrays["force_spectrum"].shape == (401, 6, 1)
    assert arrays["response_spectrum"].shape == (401, 6)
    assert arrays["outputs"].tolist() == [f"{n}:+Y" for n in range(1, 22, 4)]


def test_single_precision_halves_the_file_and_keeps_the_axis(service: Any, measured_id: str) -> None:
    double = npz(service, f"/v1/measurements/{measured_id}/arrays")
    single = npz(service, f"/v1/measurements/{measured_id}/arrays?precision=single")
    assert single["values"].dtype == np.complex64
    np.testing.assert_array_equal(single["freq"], double["freq"])
    # complex64 keeps seven digits
    np.testing.assert_allclose(single["values"], double["values"], rtol=1e-6)


def test_the_same_seed_gives_the_same_bytes(service: Any, truth: str, rig: str, measured_id: str) -> None:
    body = {"structure_id": truth, "rig_id": rig, "route": "drawn", "seed": 1}
    again = service.result_of("/v1/measurements", body)
    paths = [f"/v1/measurements/{id}/arrays" for id in (measured_id, again)]
    first, second = (service.request("GET", path).content for path in paths)
    assert first == second


def test_curves_keep_the_peaks(service: Any, measured_id: str) -> None:
    full = npz(service, f"/v1/measurements/{measured_id}/arrays")
    curves = service.get(f"/v1/measurements/{measured_id}/curves", params={"points": 60})
    assert len(curves["freq"]) <= 62
    summed = np.log(np.abs(full["values"][1:, :, 0])).sum(axis=1)
    assert full["freq"][1:][summed.argmax()] in curves["freq"]
    assert len(curves["curves"]) == 6
    assert len(curves["curves"][0]["values"]) == len(curves["freq"]) == len(curves["curves"][0]["coherence"])


def test_modes_come_with_their_scatter(service: Any, measured_id: str, truth: str, modes: str) -> None:
    shown = service.get(f"/v1/modal-models/{modes}")
    assert (shown["method"], shown["measurement_id"], len(shown["modes"])) == ("dobson", measured_id, 8)
    exact = service.get(f"/v1/structures/{truth}/modes", params={"count": 8})["frequencies"]
    found = [mode["frequency"] for mode in shown["modes"]]
    # noise of 1e-3 and 100 averages move a frequency by far less than a thousandth
    np.testing.assert_allclose(found, exact, rtol=1e-3)
    assert all(mode["frequency_spread"]["n"] >= 2 for mode in shown["modes"])
    assert npz(service, f"/v1/modal-models/{modes}/arrays")["shapes"].shape == (6, 8)


def test_the_measured_modes_pair_with_those_of_the_model(service: Any, beam: str, modes: str) -> None:
    found = service.post("/v1/correlations", {"modal_model_id": modes, "structure_id": beam})
    assert found["pairs"] == [[n, n] for n in range(1, 9)]
    assert min(found["mac"][n][n] for n in range(8)) > 0.9
    assert service.get(f"/v1/correlations/{found['id']}") == found


def test_an_update_brings_the_model_to_the_measured_frequencies(service: Any, beam: str, modes: str) -> None:
    groups = [list(range(first, first + 4)) for first in range(1, 21, 4)]
    body = {
        "structure_id": beam,
        "modal_model_id": modes,
        "parameterisation": {"macros": groups, "parts": ["stiffness"]},
        "options": {"suspect_threshold": 0.04},  # 1.3 on one member of four is 1.06 on the four
    }
    found = service.get(f"/v1/updates/{service.result_of('/v1/updates', body)}")
    stiffness = found["coefficients"]["stiffness"]
    assert max(stiffness, key=lambda member: stiffness[member]) == "7"
    assert len(found["history"]) == sum(found["iterations"].values())
    updated = service.get(f"/v1/structures/{found['structure_id']}/modes", params={"count": 8})["frequencies"]
    np.testing.assert_allclose(updated, found["frequencies"]["after"], rtol=1e-6)
    before, after, measured = (
        np.array(found["frequencies"][name]) for name in ("before", "after", "measured")
    )
    assert np.abs(after - measured).max() < 0.3 * np.abs(before - measured).max()


def test_a_diagnosis_names_the_stiffer_member(service: Any, beam: str, truth: str, measured_id: str) -> None:
    body = {
        "structure_id": beam,
        "measurement_id": measured_id,
        "suspects": ["stiffness_error", "extra_mass"],
    }
    id = service.result_of("/v1/diagnoses", body | {"hold_out": {"fraction": 0.25, "dofs": ["19:+Y"]}})
    found = service.get(f"/v1/diagnoses/{id}")
    first = found["steps"][0]
    assert (first["effect"]["kind"], first["effect"]["at"]) == ("stiffness_error", {"members": [7]})
    assert first["gap_after"] < 0.1 * first["gap_before"]
    assert truth not in str(found)
    arrays = npz(service, f"/v1/diagnoses/{id}/arrays")
    assert arrays["after"].shape == arrays["measured"].shape
    assert arrays["predicted_outputs"].tolist() == ["19:+Y"]
    assert (
        service.get(f"/v1/structures/{found['structure_id']}")["made_from"]["measurement_id"] == measured_id
    )
    assert service.get(f"/v1/rigs/{found['rig_id']}")["drive"] == "1:+Y"


def test_what_a_result_was_made_from_stays(service: Any, beam: str, measured_id: str, modes: str) -> None:
    for path in (f"/v1/measurements/{measured_id}", f"/v1/structures/{beam}", f"/v1/modal-models/{modes}"):
        assert service.request("DELETE", path).json()["code"] == "in_use"


def test_modes_from_elsewhere_are_taken(service: Any) -> None:
    body = {
        "modes": [
            {"frequency": 65.0, "loss_factor": 0.005, "shape": [1.0, [0.0, 0.5]]},
            {"frequency": 23.6, "shape": [1.0, -0.5]},
        ],
        "dofs": ["1:+Y", "11:+Y"],
    }
    stored = service.post("/v1/modal-models/import", body)
    assert [mode["frequency"] for mode in stored["modes"]] == [23.6, 65.0]
    shapes = npz(service, f"/v1/modal-models/{stored['id']}/arrays")["shapes"]
    np.testing.assert_array_equal(shapes, [[1.0, 1.0], [-0.5, 0.5j]])


def test_the_catalogue_says_unit_and_bounds_of_what_is_fitted(service: Any) -> None:
    mass = next(one for one in service.get("/v1/catalog/effects") if one["kind"] == "extra_mass")
    assert mass["parameters"]["mass"]["unit"] == "kg"
    assert mass["parameters"]["mass"]["lower"] == 0.0


@pytest.mark.parametrize(
    "family",
    [
        "effects",
        "structures",
        "excitations",
        "windows",
        "estimators",
        "extraction-methods",
        "updating-methods",
    ],
)
def test_every_choice_says_what_it_is(service: Any, family: str) -> None:
    members = service.get(f"/v1/catalog/{family}")
    assert members
    for member in members:
        assert len(member["summary"]) > 10, member
        assert not member["summary"].startswith("Return"), "to be read by people who choose, not who call"


def test_a_request_keeps_its_id(service: Any) -> None:
    given = service.request("GET", "/v1/health", headers={"X-Request-Id": "abc-1"})
    assert given.headers["x-request-id"] == "abc-1"
    strange = service.request("GET", "/v1/health", headers={"X-Request-Id": "a b"})
    assert strange.headers["x-request-id"] != "a b"
