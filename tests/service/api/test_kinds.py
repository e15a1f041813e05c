"""FRFs of any kind over HTTP, whatever was measured."""

import io
from typing import Any

import h5py
import numpy as np
import pytest

DRIVEN = {"drive": "1:+Y", "responses": ["1:+Y", "7:+Y"], "noise": {"force": 1e-3, "response": 1e-3}}
SMALL = {"frequency_max": 200.0, "n_lines": 51, "averages": 10}
STEPS = {"receptance": 2, "mobility": 1, "inertance": 0}
NOTE = "inertance at 0 Hz has no {}: that line is left out"


def npz(content: bytes) -> dict[str, Any]:
    return dict(np.load(io.BytesIO(content)))


@pytest.fixture(scope="module")
def rig_id(service: Any) -> str:
    return str(service.post("/v1/rigs", DRIVEN | {"analyser": SMALL})["id"])


@pytest.fixture(scope="module")
def test_id(service: Any, beam: str, rig_id: str) -> str:
    body = {"structure_id": beam, "rig_id": rig_id, "route": "drawn", "seed": 1}
    return str(service.result_of("/v1/measurements", body))


def content(service: Any, id: str, path: str, **params: Any) -> bytes:
    reply = service.request("GET", f"/v1/measurements/{id}/{path}", params=params)
    assert reply.status_code == 200, reply.text
    return bytes(reply.content)


@pytest.mark.parametrize("kind", ["receptance", "mobility"])
def test_arrays_come_as_another_kind_without_the_line_at_rest(service: Any, test_id: str, kind: str) -> None:
    before, after = (
        npz(content(service, test_id, "arrays")),
        npz(content(service, test_id, "arrays", kind=kind)),
    )
    assert set(after) - set(before) == {"notes"}
    assert after["notes"].tolist() == [NOTE.format(kind)]
    assert str(after["kind"]) == kind
    for name in ("freq", "coherence", "force_spectrum"):
        np.testing.assert_array_equal(after[name], before[name][1:])
    omega = 2 * np.pi * after["freq"]
    size = 1j * omega**1 if kind == "mobility" else -(omega**2)
    # from the definition; rounding
    np.testing.assert_allclose(after["values"] * size[:, None, None], before["values"][1:], rtol=1e-13)
    spectrum = after["response_spectrum"] * np.abs(size[:, None]) ** 2
    np.testing.assert_allclose(spectrum, before["response_spectrum"][1:], rtol=1e-13)


def test_the_kind_that_was_measured_changes_nothing(service: Any, test_id: str) -> None:
    before = npz(content(service, test_id, "arrays"))
    after = npz(content(service, test_id, "arrays", kind="inertance"))
    assert after.pop("notes").size == 0
    assert before.keys() == after.keys()
    for name, array in before.items():
        np.testing.assert_array_equal(after[name], array)
    for path in ("frf.uff", "thesis.frf", "arrays.h5", "curves"):
        assert content(service, test_id, path) == content(service, test_id, path, kind="inertance")


def test_hdf5_says_the_kind_in_its_units_and_notes(service: Any, test_id: str) -> None:
    with h5py.File(io.BytesIO(content(service, test_id, "arrays.h5", kind="mobility"))) as file:
        assert file["values"].attrs["unit"] == "m/s/N"
        assert file["response_spectrum"].attrs["unit"] == "(m/s)^2/Hz"
        assert file.attrs["notes"] == NOTE.format("mobility")


def test_curves_say_what_was_left_out(service: Any, test_id: str) -> None:
    found = service.get(f"/v1/measurements/{test_id}/curves", params={"kind": "receptance"})
    assert found["kind"] == "receptance"
    assert found["notes"] == [NOTE.format("receptance")]
    assert found["freq"][0] == 4.0  # the first line above 0


@pytest.mark.parametrize("kind", STEPS)
@pytest.mark.parametrize("path", ["arrays", "arrays.h5", "frf.uff", "thesis.frf"])
def test_a_file_of_any_kind_comes_back_in_as_it_went_out(
    service: Any, test_id: str, rig_id: str, path: str, kind: str
) -> None:
    params: dict[str, Any] = {"kind": kind} | ({"decimals": 16} if path == "thesis.frf" else {})
    file = content(service, test_id, path, **params)
    reply = service.request(
        "POST", "/v1/measurements/import", files={"file": ("x", file)}, data={"rig_id": rig_id}
    )
    assert reply.status_code == 201, reply.text
    back = npz(content(service, reply.json()["id"], "arrays"))
    wanted = npz(content(service, test_id, "arrays", kind=kind))
    assert str(back["kind"]) == kind
    for name in back:
        if name not in ("outputs", "inputs", "kind"):
            # the text has 16 digits; of coherence 16 decimals, however small it is
            half = 0.5e-16 if name == "coherence" else 0.0
            np.testing.assert_allclose(back[name], wanted[name], rtol=1e-13, atol=half, err_msg=name)
    # and is the measurement that it was
    again = npz(content(service, reply.json()["id"], "arrays", kind="inertance"))
    first = npz(content(service, test_id, "arrays"))
    np.testing.assert_allclose(again["values"][-50:], first["values"][1:], rtol=1e-13)


def test_a_header_of_a_universal_file_says_what_was_left_out(service: Any, test_id: str) -> None:
    head = content(service, test_id, "frf.uff", kind="receptance")[:400].decode("ascii")
    assert f"measurement; {NOTE.format('receptance')}\n" in head


def test_no_other_kinds_are_known(service: Any, test_id: str) -> None:
    for path in ("arrays", "arrays.h5", "frf.uff", "thesis.frf", "curves"):
        reply = service.request("GET", f"/v1/measurements/{test_id}/{path}", params={"kind": "compliance"})
        assert reply.status_code == 422
        assert "receptance" in reply.text


def test_modes_of_a_file_of_receptance_are_those_of_the_test(service: Any, test_id: str, rig_id: str) -> None:
    file = content(service, test_id, "frf.uff", kind="receptance")
    reply = service.request(
        "POST", "/v1/measurements/import", files={"file": ("x", file)}, data={"rig_id": rig_id}
    )
    found = []
    for id in (test_id, reply.json()["id"]):
        body = {"measurement_id": id, "method": "dobson", "n_modes": 2}
        modes = service.get(f"/v1/modal-models/{service.result_of('/v1/modal-models', body)}")["modes"]
        found.append([[mode["frequency"], mode["loss_factor"]] for mode in modes])
    # the same receptance but for rounding of omega^2, which fits magnify little
    np.testing.assert_allclose(found[1], found[0], rtol=1e-8)


def test_curves_of_a_roving_hammer_have_each_its_own_coherence(service: Any, beam: str) -> None:
    rig = {
        "exciter": {"kind": "hammer"},
        "drives": ["1:+Y", "7:+Y"],
        "responses": ["3:+Y"],
        "analyser": SMALL,
    }
    noisy = rig | {"noise": {"force": 1e-2, "response": 1e-2}}
    body = {"structure_id": beam, "rig_id": service.post("/v1/rigs", noisy)["id"], "route": "drawn"}
    id = service.result_of("/v1/measurements", body)
    curves = service.get(f"/v1/measurements/{id}/curves")["curves"]
    whole = npz(content(service, id, "arrays"))["coherence"]
    for i, curve in enumerate(curves):
        assert curve["coherence"] == whole[:, 0, i].tolist()
