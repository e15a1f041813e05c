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


# --- modes and geometry ------------------------------------------------------------------------------


def import_modes(service: Any, content: bytes) -> Any:
    """Return the reply to an import of modes."""
    return service.request("POST", "/v1/modal-models/import", files={"file": ("modes.bin", content)})


def test_a_modal_model_comes_back_from_its_universal_file(service: Any, beam: str) -> None:
    dofs = ["1:+Y", "5:-Y", "9:+Y", "9:+RZ"]
    noise = {"eigenvalue": 0.01, "eigenvector": 0.05}
    made = service.post(
        f"/v1/structures/{beam}/synthetic-modes", {"count": 4, "dofs": dofs, "noise": noise, "seed": 1}
    )
    reply = service.request("GET", f"/v1/modal-models/{made['id']}/modes.uff")
    assert reply.status_code == 200
    assert f"{made['id']}.uff" in reply.headers["content-disposition"]
    imported = import_modes(service, reply.content)
    assert imported.status_code == 201, imported.text
    back = imported.json()
    assert back["dofs"] == ["1:+Y", "5:+Y", "9:+Y", "9:+RZ"]  # in the positive sense
    assert (back["method"], back["normalisation"]) == ("imported", "mass")
    for mode, given in zip(back["modes"], made["modes"], strict=True):
        for name in ("frequency", "loss_factor"):
            assert mode[name] == pytest.approx(given[name], rel=5e-6)  # six digits at least
    shapes = [
        np.load(io.BytesIO(service.request("GET", f"/v1/modal-models/{id}/arrays").content))["shapes"]
        for id in (made["id"], back["id"])
    ]
    np.testing.assert_allclose(shapes[1], shapes[0] * np.array([1, -1, 1, 1])[:, None], rtol=5e-6)


def test_a_file_that_holds_no_modes_is_refused(service: Any, measured_id: str) -> None:
    frfs = service.request("GET", f"/v1/measurements/{measured_id}/frf.uff").content
    for content in (frfs, frfs[:700], b"no universal file", b""):
        reply = import_modes(service, content)
        assert (reply.status_code, reply.json()["code"]) == (422, "invalid_input"), reply.text
        assert reply.headers["content-type"] == "application/problem+json"
    forgotten = service.request("POST", "/v1/modal-models/import", files={"other": b""})
    assert (forgotten.status_code, forgotten.json()["code"]) == (422, "invalid_request")


def test_modes_still_come_as_json_and_the_document_tells_of_both(service: Any) -> None:
    modes = [{"frequency": 23.6, "loss_factor": 0.01, "shape": [1.0, [0.5, 0.1]]}]
    service.post("/v1/modal-models/import", {"modes": modes, "dofs": ["1:+Y", "2:+Y"]})
    operation = service.get("/openapi.json")["paths"]["/v1/modal-models/import"]["post"]
    assert set(operation["requestBody"]["content"]) == {"application/json", "multipart/form-data"}


def test_a_structure_has_its_geometry_as_a_universal_file(service: Any, beam: str) -> None:
    first, second = (service.request("GET", f"/v1/structures/{beam}/geometry.uff") for _ in range(2))
    assert first.status_code == 200
    assert first.content == second.content
    begins = [block.split()[0] for block in first.content.decode().split("    -1\n")[1::2]]
    assert begins == ["151", "164", "15", "82"]
    assert service.request("GET", "/v1/structures/none/geometry.uff").status_code == 404


# --- HDF5 and the thesis program's text --------------------------------------------------------------


def test_a_measurement_comes_back_from_its_hdf5_file(service: Any, measured_id: str, short_rig: str) -> None:
    reply = service.request("GET", f"/v1/measurements/{measured_id}/arrays.h5")
    assert (reply.status_code, reply.headers["content-type"]) == (200, "application/octet-stream")
    assert f"{measured_id}.h5" in reply.headers["content-disposition"]
    assert service.request("GET", f"/v1/measurements/{measured_id}/arrays.h5").content == reply.content
    imported = upload(service, reply.content, short_rig)
    assert imported.status_code == 201, imported.text
    before, after = arrays(service, measured_id), arrays(service, imported.json()["id"])
    assert set(before) == set(after)
    for name in before:
        np.testing.assert_array_equal(after[name], before[name], err_msg=name)


def test_a_measurement_comes_back_from_the_thesis_programs_text(
    service: Any, measured_id: str, short_rig: str
) -> None:
    reply = service.request("GET", f"/v1/measurements/{measured_id}/thesis.frf", params={"decimals": 16})
    assert reply.status_code == 200
    assert f"{measured_id}.frf" in reply.headers["content-disposition"]
    imported = upload(service, reply.content, short_rig)
    assert imported.status_code == 201, imported.text
    before, after = arrays(service, measured_id), arrays(service, imported.json()["id"])
    for name in ("freq", "values", "outputs", "inputs", "kind"):
        np.testing.assert_array_equal(after[name], before[name], err_msg=name)
    np.testing.assert_allclose(after["coherence"], before["coherence"], rtol=0, atol=1e-16)
    short = service.request("GET", f"/v1/measurements/{measured_id}/thesis.frf")
    assert len(short.content) < len(reply.content) / 2
    assert upload(service, short.content, short_rig).status_code == 201
    refused = service.request("GET", f"/v1/measurements/{measured_id}/thesis.frf", params={"decimals": 2})
    assert (refused.status_code, refused.json()["code"]) == (422, "invalid_request")


def test_a_damaged_file_of_either_kind_is_refused(service: Any, measured_id: str, short_rig: str) -> None:
    for name in ("arrays.h5", "thesis.frf"):
        whole = service.request("GET", f"/v1/measurements/{measured_id}/{name}").content
        refused = upload(service, whole[: len(whole) // 2], short_rig)
        assert (refused.status_code, refused.json()["code"]) == (422, "invalid_input"), refused.text
        assert refused.json()["context"]["field"] == "file"
