"""Requests of users with real tests: each of them succeeds over HTTP."""

import io
import json
from typing import Any

import numpy as np
import pytest

from benchmarks.strange_cases import curves, matlab, table

FREQ = np.linspace(50.0, 250.0, 401)
POINTS = ["1:+Y", "2:+Y", "3:+Y"]


def inertances() -> Any:
    omega = 2 * np.pi * FREQ[:, None]
    return -(omega**2) / ((2 * np.pi * 120.0) ** 2 * (1 + 0.02j) - omega**2) * np.array([[1.0, 0.5, -0.5]])


def arrays(**more: Any) -> bytes:
    given = {"freq": FREQ, "values": inertances()[..., None], "kind": "inertance"}
    file = io.BytesIO()
    np.savez(file, **({**given, "outputs": POINTS, "inputs": ["1:+Y"]} | more))
    return file.getvalue()


def imported(service: Any, *files: Any, **form: Any) -> Any:
    parts = [("file", file) for file in files]
    reply = service.request("POST", "/v1/measurements/import", files=parts, data=form)
    assert reply.status_code == 201, reply.text
    return reply.json()


def declared(service: Any, **rig: Any) -> str:
    return str(service.post("/v1/rigs", rig)["id"])


ANALYSER = {"frequency_max": 250.0, "n_lines": 501, "averages": 20}


def test_a_rig_has_51201_lines(service: Any) -> None:
    analyser = {"frequency_max": 1600.0, "n_lines": 51_201}
    declared(service, drive="1:+Y", responses=POINTS, analyser=analyser)


@pytest.mark.parametrize("with_rig", [False, True])
def test_a_band_cut_from_a_test_is_imported(service: Any, with_rig: bool) -> None:
    rig = {"drive": "1:+Y", "responses": POINTS, "analyser": ANALYSER}
    form = {"rig_id": declared(service, **rig)} if with_rig else {}
    about = imported(service, ("a.npz", arrays()), **form)
    assert (about["frequency_min"], about["n_lines"]) == (50.0, 401)


@pytest.mark.parametrize("with_rig", [False, True])
def test_a_roving_hammer_is_imported(service: Any, with_rig: bool) -> None:
    analyser = ANALYSER | {"excitation": {"kind": "periodic_random"}}  # as the service writes it
    rig = {"exciter": {"kind": "hammer"}, "drives": POINTS, "responses": ["1:+Y"], "analyser": analyser}
    form = {"rig_id": declared(service, **rig)} if with_rig else {}
    roved = arrays(values=inertances()[:, None, :], outputs=["1:+Y"], inputs=POINTS)
    assert imported(service, ("a.npz", roved), **form)["inputs"] == POINTS


def test_accelerance_is_inertance(service: Any) -> None:
    assert imported(service, ("a.npz", arrays(kind="accelerance")))["kind"] == "inertance"


def test_a_coherence_that_rounding_leaves_above_one_is_imported(service: Any) -> None:
    coherence = np.full((401, 3), 0.999)
    coherence[7] = 1.0000001
    about = imported(service, ("a.npz", arrays(coherence=coherence)))
    content = service.request("GET", f"/v1/measurements/{about['id']}/arrays").content
    assert np.load(io.BytesIO(content))["coherence"].max() == 1.0


def test_values_of_one_input_have_two_axes(service: Any) -> None:
    about = imported(service, ("a.npz", arrays(values=inertances())))
    assert (about["outputs"], about["inputs"]) == (POINTS, ["1:+Y"])


def test_matlab_files_are_imported(service: Any) -> None:
    f, h = curves(n_out=3)
    variables = json.dumps({"freq": "f", "H": "frf"})
    (file,) = matlab(f=f, frf=h)
    assert imported(service, file, variables=variables)["n_lines"] == len(f)


def test_csv_files_are_imported(service: Any) -> None:
    f, h = curves()
    file = ("tail.csv", table([f, h[:, 0, 0].real, h[:, 0, 0].imag]))
    assert imported(service, file, map=json.dumps({"tail": "3:+Y"}))["outputs"] == ["3:+Y"]
