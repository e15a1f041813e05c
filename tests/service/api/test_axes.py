"""Long and cut frequency axes, and bands of lines, over HTTP."""

import io
from typing import Any

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.fe.catalogued import STRUCTURES
from modallab.rig.exact import exact_frf

POINTS = [f"{n}:+Y" for n in range(1, 19, 2)]
BEAM = STRUCTURES["chapter-5-beam"]()


def sent(service: Any, arrays: dict[str, Any], rig_id: str | None = None) -> Any:
    """Return the reply to an upload of arrays."""
    file = io.BytesIO()
    np.savez(file, **arrays)
    form = {} if rig_id is None else {"rig_id": rig_id}
    files = {"file": ("frf.npz", file.getvalue())}
    reply = service.request("POST", "/v1/measurements/import", files=files, data=form)
    assert reply.status_code == 201, reply.text
    return reply.json()


def arrays_of(service: Any, id: str) -> dict[str, Any]:
    return dict(np.load(io.BytesIO(service.request("GET", f"/v1/measurements/{id}/arrays").content)))


def beam_test(lines: slice) -> dict[str, Any]:
    """Return exact inertances of the beam at nine points and some of 51,201 lines to 1600 Hz."""
    frf = exact_frf(BEAM, Dof(1, "Y"), [Dof.parse(p) for p in POINTS], frequency_max=1600.0, n_lines=51_201)
    arrays: dict[str, Any] = {
        "freq": frf.freq[lines],
        "values": frf.values[lines],
        "kind": "inertance",
        "averages": 100.0,
    }
    coherence = np.full((len(arrays["freq"]), 9), 0.9999)
    return arrays | {"outputs": POINTS, "inputs": ["1:+Y"], "coherence": coherence}


def test_a_million_lines_go_in_and_come_back_as_they_were(service: Any) -> None:
    freq = 300.0 + np.arange(1_000_000) / 1024
    poles = [(2 * np.pi * f) ** 2 * (1 + 0.002j) - (2 * np.pi * freq) ** 2 for f in (420.0, 421.5, 900.0)]
    values = np.array([1 / pole for pole in poles]).sum(axis=0)[:, None, None]
    given = {"freq": freq, "values": values, "outputs": ["1:+Z"], "inputs": ["1:+Z"], "kind": "receptance"}
    about = sent(service, given)
    assert about["n_lines"] == 1_000_000
    found = arrays_of(service, about["id"])
    np.testing.assert_array_equal(found["freq"], freq)
    np.testing.assert_array_equal(found["values"], values)
    lines = {"bands": [[415.0, 427.0]], "exclude": [[1000.0, 1276.0]]}
    body = {"measurement_id": about["id"], "method": "lscf", **lines}
    model = service.get(f"/v1/modal-models/{service.result_of('/v1/modal-models', body)}")
    # a thousandth of the half-power bandwidth, 0.84 Hz: the mode at 900 Hz is a residual term to the others
    assert [mode["frequency"] for mode in model["modes"]] == pytest.approx([420.0, 421.5], abs=1e-3)
    assert model["exclude"] == [[1000.0, 1276.0]]


@pytest.fixture(scope="module")
def rig_of_file(service: Any) -> str:
    analyser = {"frequency_max": 1600.0, "n_lines": 51_201, "averages": 100}
    return str(service.post("/v1/rigs", {"drive": "1:+Y", "responses": POINTS, "analyser": analyser})["id"])


BAND = [[30.0, 130.0]]


@pytest.mark.parametrize("with_rig", [False, True], ids=["alone", "with its rig"])
@pytest.mark.parametrize("lines", [slice(None), slice(640, 16_001)], ids=["whole", "20 to 500 Hz"])
def test_51201_lines_are_read_and_diagnosed_in_a_band(
    service: Any, beam: str, rig_of_file: str, with_rig: bool, lines: slice
) -> None:
    given = beam_test(lines)
    about = sent(service, given, rig_of_file if with_rig else None)
    assert (about["n_lines"], about["frequency_min"]) == (len(given["freq"]), given["freq"][0])
    np.testing.assert_allclose(arrays_of(service, about["id"])["freq"], given["freq"], rtol=1e-12)  # rounding
    body = {"structure_id": beam, "measurement_id": about["id"], "suspects": ["extra_mass"], "bands": BAND}
    found = service.get(f"/v1/diagnoses/{service.result_of('/v1/diagnoses', body)}")
    assert found["verdict"] == "nothing_missing"
    arrays = dict(np.load(io.BytesIO(service.request("GET", f"/v1/diagnoses/{found['id']}/arrays").content)))
    assert (arrays["freq"].min(), arrays["freq"].max()) == (30.0, 130.0)


@pytest.fixture(scope="module")
def measured(service: Any) -> str:
    arrays = beam_test(slice(None, None, 64))
    return str(sent(service, arrays)["id"])


def test_the_rig_of_a_file_alone_may_be_declared(service: Any) -> None:
    arrays = beam_test(slice(None, None, 64))
    roved = {
        **arrays,
        "values": arrays["values"].swapaxes(1, 2),
        "inputs": POINTS,
        "outputs": ["1:+Y"],
        "coherence": arrays["coherence"][:, None, :],
    }
    alone = sent(service, roved)
    log = service.get(f"/v1/measurements/{alone['id']}/log")
    assert log["rig"]["exciter"]["kind"] == "hammer"
    declared = service.post("/v1/rigs", log["rig"])["id"]
    assert sent(service, roved, declared)["n_lines"] == alone["n_lines"]


@pytest.mark.parametrize("method", ["dobson", "lscf"])
def test_lines_left_out_move_no_mode(service: Any, measured: str, method: str) -> None:
    def frequencies(**lines: Any) -> Any:
        body = {"measurement_id": measured, "method": method, **lines}
        model = service.get(f"/v1/modal-models/{service.result_of('/v1/modal-models', body)}")
        return np.array([mode["frequency"] for mode in model["modes"]])

    every, some = frequencies(), frequencies(exclude=[[150.0, 190.0], [700.0, 1600.0]])
    below = every[every < 600.0]
    assert len(below) > 2
    nearest = np.abs(some[:, None] - below).min(axis=0)
    assert (nearest < 1e-3 * below).all()  # the FRFs are exact, the residual terms differ


def test_frfs_are_correlated_in_bands(service: Any, beam: str, measured: str) -> None:
    modes = service.post(f"/v1/structures/{beam}/synthetic-modes", {"count": 4, "dofs": POINTS})["id"]
    body = {"modal_model_id": modes, "structure_id": beam, "measurement_id": measured}
    found = service.post("/v1/correlations", body | {"bands": BAND, "exclude": [[60.0, 80.0]]})
    arrays = dict(
        np.load(io.BytesIO(service.request("GET", f"/v1/correlations/{found['id']}/arrays").content))
    )
    freq = arrays["fdac_freq"] if "fdac_freq" in arrays else arrays["freq"]
    assert (freq.min(), freq.max()) == (30.0, 130.0)
    assert not ((freq >= 60.0) & (freq <= 80.0)).any()


def test_a_model_is_updated_in_bands(service: Any, beam: str, measured: str) -> None:
    body = {
        "structure_id": beam,
        "measurement_id": measured,
        "method": "frf_residual",
        "bands": [[20.0, 400.0]],
        "parameterisation": {"macros": [list(range(1, 21))], "parts": ["stiffness"]},
    }
    found = service.get(f"/v1/updates/{service.result_of('/v1/updates', body)}")
    assert 20.0 <= found["responses"]["band"][0] < found["responses"]["band"][1] <= 400.0


WRONG = [
    ("bands", [[130.0, 30.0]]),
    ("bands", [[2000.0, 3000.0]]),
    ("exclude", [[0.0, 1600.0]]),
]


@pytest.mark.parametrize(("name", "bands"), WRONG)
def test_bands_without_lines_are_refused_by_name(
    service: Any, beam: str, measured: str, name: str, bands: Any
) -> None:
    modes = service.post(f"/v1/structures/{beam}/synthetic-modes", {"count": 4, "dofs": POINTS})["id"]
    ids = {"structure_id": beam, "measurement_id": measured, name: bands}
    for path, body in (
        ("/v1/diagnoses", ids),
        ("/v1/updates", ids | {"method": "frf_residual"}),
        ("/v1/correlations", ids | {"modal_model_id": modes}),
    ):
        reply = service.request("POST", path, json=body)
        assert (reply.status_code, reply.json()["context"]["field"]) == (422, name), reply.text


def test_an_update_on_modes_has_no_bands(service: Any, beam: str) -> None:
    modes = service.post(f"/v1/structures/{beam}/synthetic-modes", {"count": 4, "dofs": POINTS})["id"]
    body = {"structure_id": beam, "modal_model_id": modes, "bands": BAND}
    reply = service.request("POST", "/v1/updates", json=body)
    assert (reply.status_code, reply.json()["context"]["field"]) == (422, "bands")
