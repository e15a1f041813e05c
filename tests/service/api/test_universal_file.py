"""Measurements go out as universal files and come back as they were."""

import io
from typing import Any

import numpy as np
import pytest

RESPONSES = ["1:+Y", "5:-Y", "9:+Y"]


@pytest.fixture(scope="module")
def short_rig(service: Any) -> str:
    """A rig with three responses; one accelerometer looks the other way."""
    rig = {"drive": "1:+Y", "responses": RESPONSES, "analyser": {"n_lines": 101, "averages": 20}}
    return str(service.post("/v1/rigs", rig)["id"])


@pytest.fixture(scope="module")
def measured_id(service: Any, beam: str, short_rig: str) -> str:
    """A test on that rig."""
    body = {"structure_id": beam, "rig_id": short_rig, "route": "sampled", "seed": 1}
    return str(service.result_of("/v1/measurements", body))


def arrays(service: Any, id: str) -> Any:
    """Return a measurement's arrays."""
    return np.load(io.BytesIO(service.request("GET", f"/v1/measurements/{id}/arrays").content))


def upload(service: Any, content: bytes, rig: str, **fields: Any) -> Any:
    """Return the reply to an import under a name that says nothing."""
    files = {"file": ("measured.bin", content)}
    return service.request("POST", "/v1/measurements/import", files=files, data={"rig_id": rig, **fields})


def test_a_measurement_comes_back_from_its_universal_file(
    service: Any, measured_id: str, short_rig: str
) -> None:
    reply = service.request("GET", f"/v1/measurements/{measured_id}/frf.uff")
    assert reply.status_code == 200
    assert f"{measured_id}.uff" in reply.headers["content-disposition"]
    imported = upload(service, reply.content, short_rig)
    assert imported.status_code == 201, imported.text
    assert imported.json()["outputs"] == RESPONSES
    assert imported.json()["averages"] == 20  # the rig's: the format has no place for them
    before, after = arrays(service, measured_id), arrays(service, imported.json()["id"])
    assert set(before) == set(after)
    for name in ("freq", "values", "coherence", "force_spectrum", "response_spectrum", "outputs", "kind"):
        np.testing.assert_array_equal(after[name], before[name], err_msg=name)


def test_averages_may_be_told_beside_the_file(service: Any, measured_id: str, short_rig: str) -> None:
    content = service.request("GET", f"/v1/measurements/{measured_id}/frf.uff").content
    npz = service.request("GET", f"/v1/measurements/{measured_id}/arrays").content
    for file in (content, npz):
        assert upload(service, file, short_rig, averages=94.8).json()["averages"] == 94.8
    refused = upload(service, content, short_rig, averages=0.5)
    assert (refused.status_code, refused.json()["code"]) == (422, "invalid_request")


def test_a_measurement_that_is_not_there_has_no_universal_file(service: Any) -> None:
    reply = service.request("GET", "/v1/measurements/none/frf.uff")
    assert (reply.status_code, reply.json()["code"]) == (404, "not_found")
