"""Files without a log book: the rig is what they tell."""

import io
from typing import Any

import numpy as np
import pytest

KNOWN = np.array([62.0, 81.0, 107.0])
LOSS = 0.02
DOFS = ["1:+Z", "2:+Z", "3:-Z"]
SHAPES = np.array([[1.0, 0.7, -0.4], [0.5, -0.9, 1.1], [-1.2, 0.6, 0.8]])  # (n_dof, n_modes) 1/sqrt(kg)


def receptance(freq: Any) -> Any:
    eigenvalue = (2 * np.pi * KNOWN) ** 2 * (1 + 1j * LOSS)
    poles = 1 / (eigenvalue - (2 * np.pi * freq[:, None]) ** 2)
    return (poles[:, None, :] * SHAPES * SHAPES[0]).sum(axis=2)


def sent(service: Any, freq: Any, **more: Any) -> Any:
    file = io.BytesIO()
    values = receptance(freq)[:, :, None]
    given = {"freq": freq, "values": values, "outputs": DOFS, "inputs": ["1:+Z"], "kind": "receptance"}
    np.savez(file, **(given | more))
    return service.request("POST", "/v1/measurements/import", files={"file": ("frf.npz", file.getvalue())})


@pytest.mark.parametrize(
    "freq",
    [
        pytest.param(np.arange(0.0, 140.0, 0.5), id="from 0 Hz"),
        pytest.param(np.arange(50.0, 120.0, 0.25), id="a zoomed band"),
        pytest.param(np.concatenate([np.arange(50.0, 70, 0.25), np.arange(70.0, 120, 0.5)]), id="uneven"),
    ],
)
def test_a_file_alone_gives_its_modes_whatever_its_lines(service: Any, freq: Any) -> None:
    reply = sent(service, freq)
    assert reply.status_code == 201, reply.text
    about = reply.json()
    assert "no log book: the rig is what the file itself tells" in about["notes"]
    rig = service.get(f"/v1/rigs/{about['rig_id']}")
    assert (rig["drive"], rig["responses"]) == ("1:+Z", DOFS)
    id = service.result_of("/v1/modal-models", {"measurement_id": about["id"]})
    modes = service.get(f"/v1/modal-models/{id}")["modes"]
    # exact lines of nothing but these modes: what the rounds of taking neighbours off leave
    np.testing.assert_allclose([mode["frequency"] for mode in modes], KNOWN, rtol=1e-5)
    np.testing.assert_allclose([mode["loss_factor"] for mode in modes], LOSS, rtol=1e-3)
    shapes = np.load(io.BytesIO(service.request("GET", f"/v1/modal-models/{id}/arrays").content))["shapes"]
    np.testing.assert_allclose(shapes.real, SHAPES * np.sign(SHAPES[0]), rtol=1e-3)
    assert service.get(f"/v1/measurements/{about['id']}/curves")["freq"][-1] == freq[-1]


def test_what_a_file_says_of_averages_and_hammers_is_kept(service: Any) -> None:
    freq = np.arange(0.0, 140.0, 0.5)
    assert sent(service, freq, averages=np.array(7.0)).json()["averages"] == 7.0
    values = receptance(freq)[:, None, :]
    roved = sent(service, freq, values=values, outputs=["1:+Z"], inputs=DOFS).json()
    rig = service.get(f"/v1/rigs/{roved['rig_id']}")
    assert rig["exciter"]["kind"] == "hammer"
    assert len(service.get(f"/v1/modal-models/{_modes(service, roved['id'])}")["dofs"]) == 3


def _modes(service: Any, measured: str) -> str:
    return str(service.result_of("/v1/modal-models", {"measurement_id": measured}))


def test_a_file_with_hardly_a_line_is_refused(service: Any) -> None:
    reply = sent(service, np.array([1.0, 2.0, 3.0]))
    assert (reply.status_code, reply.json()["context"]["field"]) == (422, "freq")


def test_a_diagnosis_of_lines_that_are_not_evenly_spaced_is_refused(service: Any, beam: str) -> None:
    freq = np.arange(50.0, 120.0, 0.25)
    freq[17] += 0.1
    measured = sent(service, freq, outputs=["1:+Y", "5:+Y", "9:+Y"], inputs=["1:+Y"])
    assert any("line 18, 54.35 Hz" in note for note in measured.json()["notes"])
    body = {"structure_id": beam, "measurement_id": measured.json()["id"]}
    reply = service.request("POST", "/v1/diagnoses", json=body)
    assert (reply.status_code, reply.json()["context"]["field"]) == (422, "freq")
