"""Updates on measured FRFs over HTTP."""

import io
from typing import Any

import numpy as np
import pytest

SENSORS = [f"{n}:+Y" for n in range(1, 22, 2)]
BODY = {"method": "frf_residual", "parameterisation": {"macros": "each", "parts": ["mass", "stiffness"]}}


@pytest.fixture(scope="module")
def rig(service: Any) -> str:
    analyser = {"frequency_max": 1600.0, "n_lines": 161}
    rig = {
        "drive": "1:+Y",
        "responses": SENSORS,
        "analyser": analyser,
        "noise": {"force": 0.0, "response": 1e-4},
    }
    return str(service.post("/v1/rigs", rig)["id"])


@pytest.fixture(scope="module")
def test_of_wrong_beam(service: Any, beam: str, rig: str) -> str:
    changes = [
        {"members": [11, 12], "property": "modulus", "factor": 1.8},
        {"members": [4], "property": "density", "factor": 0.5},
    ]
    wrong = service.post(f"/v1/structures/{beam}/changes", {"changes": changes})["id"]
    asked = {"structure_id": wrong, "rig_id": rig, "route": "drawn", "seed": 2}
    return str(service.result_of("/v1/measurements", asked))


@pytest.fixture(scope="module")
def found(service: Any, beam: str, test_of_wrong_beam: str) -> Any:
    body = BODY | {"structure_id": beam, "measurement_id": test_of_wrong_beam}
    return service.get(f"/v1/updates/{service.result_of('/v1/updates', body)}")


def test_wrong_members_are_found_on_the_measured_responses(found: Any) -> None:
    assert found["converged"], found["stopped_because"]
    assert found["suspected"] == {"mass": [4], "stiffness": [11, 12]}
    low, high = found["intervals"]["stiffness"]["11"]
    assert low < found["coefficients"]["stiffness"]["11"] < high
    assert abs(found["coefficients"]["mass"]["4"] - 0.5) < 0.05


def test_how_well_responses_fit_is_told(found: Any) -> None:
    fit = found["responses"]
    assert fit["before"] > 100 * fit["after"]
    assert abs(fit["after"] - 1) < 0.2
    assert fit["outputs"] == SENSORS
    assert len(fit["by_frf_after"]) == len(SENSORS)
    assert found["kind"] == "response_based"
    assert fit["n_lines"] > 0
    assert fit["band"][0] < fit["band"][1]
    assert found["frequencies"].keys() == {"before", "location", "after"}
    assert len(found["frequencies"]["before"]) == len(found["frequencies"]["after"])
    assert "mac" not in found


def test_the_corrected_model_is_a_structure(service: Any, found: Any, test_of_wrong_beam: str) -> None:
    modes = service.get(f"/v1/structures/{found['structure_id']}/modes", params={"count": 3})
    assert modes["frequencies"] == pytest.approx(found["frequencies"]["after"][:3])
    assert found["made_from"]["measurement_id"] == test_of_wrong_beam


def refused(service: Any, body: dict[str, Any]) -> Any:
    reply = service.request("POST", "/v1/updates", json=body)
    assert reply.status_code == 422, reply.text
    return reply.json()["context"]


def test_modes_and_responses_are_each_for_their_methods(
    service: Any, beam: str, test_of_wrong_beam: str
) -> None:
    known = service.post(f"/v1/structures/{beam}/synthetic-modes", {"count": 5, "dofs": SENSORS})["id"]
    on_responses = BODY | {"structure_id": beam}
    assert refused(service, on_responses)["field"] == "measurement_id"
    both = on_responses | {"modal_model_id": known, "measurement_id": test_of_wrong_beam}
    assert refused(service, both)["field"] == "modal_model_id"
    by_modes = {"structure_id": beam, "method": "one_shot"}
    assert refused(service, by_modes)["field"] == "modal_model_id"
    both = by_modes | {"modal_model_id": known, "measurement_id": test_of_wrong_beam}
    assert refused(service, both)["field"] == "measurement_id"
    stated = by_modes | {"modal_model_id": known, "noise_floor": 0.01}
    assert refused(service, stated)["field"] == "noise_floor"


def test_options_of_modes_mean_nothing_here(service: Any, beam: str, test_of_wrong_beam: str) -> None:
    body = BODY | {"structure_id": beam, "measurement_id": test_of_wrong_beam, "options": {"min_mac": 0.5}}
    assert refused(service, body)["field"] == "min_mac"


def test_sensors_that_the_model_lacks_are_refused(service: Any, test_of_wrong_beam: str) -> None:
    short = service.post("/v1/structures", {"kind": "catalogue", "name": "cantilever"})["id"]
    body = BODY | {"structure_id": short, "measurement_id": test_of_wrong_beam}
    assert refused(service, body)["value"] == "1:+Y"


def test_the_catalogue_offers_the_method(service: Any) -> None:
    offered = {one["kind"]: one for one in service.get("/v1/catalog/updating-methods")}
    assert {"prior", "underdetermined", "tolerance"} <= offered["frf_residual"]["parameters"].keys()
    assert "min_mac" not in offered["frf_residual"]["parameters"]


def test_responses_of_a_file_without_coherence_need_a_stated_error(
    service: Any, beam: str, rig: str, test_of_wrong_beam: str
) -> None:
    reply = service.request("GET", f"/v1/measurements/{test_of_wrong_beam}/arrays")
    with np.load(io.BytesIO(reply.content)) as arrays:
        kept = {name: arrays[name] for name in ("freq", "values", "outputs", "inputs", "kind")}
    file = io.BytesIO()
    np.savez(file, **kept)
    form = {"files": {"file": ("frf.npz", file.getvalue())}, "data": {"rig_id": rig}}
    brought = service.request("POST", "/v1/measurements/import", **form)
    assert brought.status_code == 201, brought.text
    body = BODY | {"structure_id": beam, "measurement_id": brought.json()["id"]}
    assert refused(service, body)["field"] == "coherence"
    found = service.get(f"/v1/updates/{service.result_of('/v1/updates', body | {'noise_floor': 0.01})}")
    assert found["suspected"] == {"mass": [4], "stiffness": [11, 12]}
