"""Time records over HTTP: arrays, a sound file, and what cannot be had."""

import io
from typing import Any

import numpy as np
import pytest
from scipy.io import wavfile

SMALL = {"frequency_max": 200.0, "n_lines": 51, "averages": 10}
DRIVEN = {"drive": "1:+Y", "responses": ["1:+Y", "7:+Y"], "analyser": SMALL}


def npz(content: bytes) -> dict[str, Any]:
    return dict(np.load(io.BytesIO(content)))


@pytest.fixture(scope="module")
def rig_id(service: Any) -> str:
    return str(service.post("/v1/rigs", DRIVEN)["id"])


def test_of(service: Any, beam: str, rig_id: str, **more: Any) -> str:
    body = {"structure_id": beam, "rig_id": rig_id, "seed": 1} | more
    return str(service.result_of("/v1/measurements", body))


test_of.__test__ = False  # type: ignore[attr-defined]


@pytest.fixture(scope="module")
def test_id(service: Any, beam: str, rig_id: str) -> str:
    return test_of(service, beam, rig_id, records=10)


def test_the_records_make_the_measured_frf(service: Any, test_id: str) -> None:
    test = npz(service.request("GET", f"/v1/measurements/{test_id}/arrays").content)
    records = npz(service.request("GET", f"/v1/measurements/{test_id}/records").content)
    assert records["inputs"].tolist() == [["1:+Y"]]
    assert records["outputs"].tolist() == [["1:+Y", "7:+Y"]]
    assert str(records["force_unit"]) == "N"
    assert str(records["response_unit"]) == "m/s^2"
    assert records["force"].shape[0] == 10
    # a record lasts one over the line spacing, 4 Hz
    assert records["force"].shape[1] == pytest.approx(records["sample_rate"] / 4)
    force, response = np.fft.rfft(records["force"][..., 0, 0]), np.fft.rfft(records["response"][..., 0, 1])
    h1 = (force.conj() * response).mean(axis=0) / (np.abs(force) ** 2).mean(axis=0)
    np.testing.assert_allclose(h1[:51], test["values"][:, 1, 0], rtol=1e-9)  # rounding


def test_arrays_of_the_measurement_are_those_without_records(
    service: Any, beam: str, rig_id: str, test_id: str
) -> None:
    without = test_of(service, beam, rig_id)
    arrays = [
        npz(service.request("GET", f"/v1/measurements/{id}/arrays").content) for id in (test_id, without)
    ]
    assert arrays[0].keys() == arrays[1].keys()
    for name, array in arrays[0].items():
        np.testing.assert_array_equal(array, arrays[1][name])
    assert [service.get(f"/v1/measurements/{id}")["n_records"] for id in (test_id, without)] == [10, 0]


def test_the_sound_file_holds_the_records_one_after_another(service: Any, test_id: str) -> None:
    reply = service.request("GET", f"/v1/measurements/{test_id}/records?format=wav")
    assert reply.headers["content-type"] == "audio/wav"
    rate, sound = wavfile.read(io.BytesIO(reply.content))
    records = npz(service.request("GET", f"/v1/measurements/{test_id}/records").content)
    assert rate == records["sample_rate"]
    expected = np.concatenate([records["force"], records["response"]], axis=-1).reshape(-1, 3)
    np.testing.assert_allclose(sound, expected, rtol=1e-7)  # single precision


def test_records_come_as_json(service: Any, test_id: str) -> None:
    reply = service.request(
        "GET", f"/v1/measurements/{test_id}/records", headers={"Accept": "application/json"}
    )
    assert reply.status_code == 200
    assert np.shape(reply.json()["force"])[0] == 10


def test_a_sample_rate_of_a_part_of_a_hertz_makes_no_sound_file(service: Any, beam: str) -> None:
    body = DRIVEN | {"analyser": SMALL | {"frequency_max": 200.3}}
    id = test_of(service, beam, service.post("/v1/rigs", body)["id"], records=1)
    reply = service.request("GET", f"/v1/measurements/{id}/records?format=wav")
    assert reply.status_code == 422
    assert reply.json()["context"] == {"field": "format", "value": "wav", "allowed": "npz"}


def test_a_measurement_without_records_says_how_to_have_them(service: Any, beam: str, rig_id: str) -> None:
    id = test_of(service, beam, rig_id)
    reply = service.request("GET", f"/v1/measurements/{id}/records")
    assert reply.status_code == 404
    assert "state `records`" in reply.json()["detail"]


@pytest.mark.parametrize(
    ("more", "allowed"),
    [
        ({"records": 11}, {"minimum": 0, "maximum": 10}),
        ({"records": 1, "route": "drawn"}, 0),
    ],
)
def test_records_that_cannot_be_kept_are_refused_at_once(
    service: Any, beam: str, rig_id: str, more: dict[str, Any], allowed: Any
) -> None:
    body = {"structure_id": beam, "rig_id": rig_id} | more
    problem = service.post("/v1/measurements", body, status=422)
    assert problem["context"]["field"] == "records"
    assert problem["context"]["value"] == more["records"]
    assert problem["context"]["allowed"] == allowed


@pytest.mark.parametrize("records", [-1, 1.5, "all", 2**40])
def test_a_number_of_records_is_a_count(service: Any, beam: str, rig_id: str, records: Any) -> None:
    body = {"structure_id": beam, "rig_id": rig_id, "records": records}
    problem = service.post("/v1/measurements", body, status=422)
    assert "records" in str(problem["context"])
