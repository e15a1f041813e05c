"""Estimates over HTTP while averages are taken: arrays, and what cannot be had."""

import io
from typing import Any

import numpy as np
import pytest

from modallab.store.npz import pack, unpack
from tests.service.api.project_files import files_of, form, zipped

SMALL = {"frequency_max": 200.0, "n_lines": 51, "averages": 10}
NOISE = {"force": 1e-2, "response": 1e-1}
DRIVEN = {"drive": "1:+Y", "responses": ["1:+Y", "7:+Y"], "analyser": SMALL, "noise": NOISE}


def npz(content: bytes) -> dict[str, Any]:
    return dict(np.load(io.BytesIO(content)))


@pytest.fixture(scope="module")
def rig_id(service: Any) -> str:
    return str(service.post("/v1/rigs", DRIVEN)["id"])


def measured(service: Any, beam: str, rig_id: str, **more: Any) -> str:
    body = {"structure_id": beam, "rig_id": rig_id, "seed": 1} | more
    return str(service.result_of("/v1/measurements", body))


@pytest.fixture(scope="module")
def watched(service: Any, beam: str, rig_id: str) -> str:
    return measured(service, beam, rig_id, estimates=4, records=4)


def test_the_last_estimate_is_the_measurement(service: Any, watched: str) -> None:
    test = npz(service.request("GET", f"/v1/measurements/{watched}/arrays").content)
    estimates = npz(service.request("GET", f"/v1/measurements/{watched}/estimates").content)
    assert estimates["n_averages"].tolist() == [1, 2, 4, 10]
    assert service.get(f"/v1/measurements/{watched}")["n_estimates"] == 4
    np.testing.assert_array_equal(estimates["values"][-1], test["values"])
    np.testing.assert_array_equal(estimates["coherence"][-1], test["coherence"])
    for name in ("freq", "outputs", "inputs", "kind"):
        np.testing.assert_array_equal(estimates[name], test[name])


def test_an_estimate_is_what_the_first_records_make(service: Any, watched: str) -> None:
    records = npz(service.request("GET", f"/v1/measurements/{watched}/records").content)
    estimates = npz(service.request("GET", f"/v1/measurements/{watched}/estimates").content)
    force, response = (np.fft.rfft(records[name][:4, :, 0], axis=1) for name in ("force", "response"))
    h1 = (force.conj() * response).mean(axis=0) / (np.abs(force) ** 2).mean(axis=0)
    np.testing.assert_allclose(estimates["values"][2, :, :, 0], h1[:51], rtol=1e-6)  # single precision


def test_other_replies_are_those_of_a_measurement_without_estimates(
    service: Any, beam: str, rig_id: str, watched: str
) -> None:
    without = measured(service, beam, rig_id)
    pair = [npz(service.request("GET", f"/v1/measurements/{id}/arrays").content) for id in (watched, without)]
    assert pair[0].keys() == pair[1].keys()
    for name, array in pair[0].items():
        np.testing.assert_array_equal(array, pair[1][name])
    reply = service.request("GET", f"/v1/measurements/{without}/estimates")
    assert reply.status_code == 404
    assert "state `estimates`" in reply.json()["detail"]
    assert service.get(f"/v1/measurements/{without}")["n_estimates"] == 0


def test_estimates_come_as_json_and_in_single_precision(service: Any, watched: str) -> None:
    path = f"/v1/measurements/{watched}/estimates"
    reply = service.request("GET", path, headers={"Accept": "application/json"})
    assert np.shape(reply.json()["values"]) == (4, 51, 2, 1, 2)
    assert npz(service.request("GET", f"{path}?precision=single").content)["values"].dtype == np.complex64


def test_a_project_file_has_the_estimates_and_those_of_another_test_are_refused(
    service: Any, watched: str
) -> None:
    files = files_of(service.request("GET", "/v1/projects/export").content)
    reply = service.request("POST", "/v1/projects/import", **form(zipped(files)))
    copy = reply.json()["ids"][watched]
    pair = [service.request("GET", f"/v1/measurements/{id}/estimates").content for id in (watched, copy)]
    assert pair[0] == pair[1]
    arrays = unpack(files[f"{watched}.npz"])
    for name in ("values", "coherence"):  # of fewer lines
        arrays[f"estimates_{name}"] = arrays[f"estimates_{name}"][:, 1:]
    files[f"{watched}.npz"] = pack(arrays)
    assert service.request("POST", "/v1/projects/import", **form(zipped(files))).status_code == 422


@pytest.mark.parametrize(
    ("more", "allowed"),
    [
        ({"estimates": 101}, {"maximum": 100}),
        ({"estimates": -1}, {"minimum": 0}),
        ({"estimates": 3, "route": "drawn"}, 0),
    ],
)
def test_estimates_that_cannot_be_kept_are_refused_at_once(
    service: Any, beam: str, rig_id: str, more: dict[str, Any], allowed: Any
) -> None:
    body = {"structure_id": beam, "rig_id": rig_id} | more
    problem = service.post("/v1/measurements", body, status=422)
    assert "estimates" in problem["context"]["field"]
    assert problem["context"]["allowed"] == allowed
