"""The exact FRFs of a structure, without a rig."""

import io
from typing import Any

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.receptance import direct_receptance
from tests.rigs import beam_system

ASKED = {"drive": "1:+Y", "responses": ["1:+Y", "11:-Y"], "frequency_max": 800.0, "n_lines": 101}


def frf(service: Any, structure: str, **changes: Any) -> dict[str, Any]:
    reply = service.request("GET", f"/v1/structures/{structure}/frf", params=ASKED | changes)
    assert reply.status_code == 200, reply.text
    return dict(np.load(io.BytesIO(reply.content)))


@pytest.mark.parametrize(("kind", "steps"), [("receptance", 0), ("mobility", 1), ("inertance", 2)])
def test_it_solves_the_equations_of_motion(service: Any, beam: str, kind: str, steps: int) -> None:
    found = frf(service, beam, kind=kind)
    assert (str(found["kind"]), found["outputs"].tolist()) == (kind, ["1:+Y", "11:-Y"])
    assert len(found["freq"]) == (101 if kind == "inertance" else 100)
    assert found["notes"].size == (0 if kind == "inertance" else 1)
    lines = found["freq"] > 0
    system, freq = beam_system(), found["freq"][lines]
    left = system.selection((Dof(1, "Y"), Dof(11, "Y", -1)))
    # the matrices solved line by line, against a sum of modes
    alpha = direct_receptance(system, freq, left, system.selection((Dof(1, "Y"),)))
    exact = (2j * np.pi * freq[:, None, None]) ** steps * alpha
    # rounding: stiffnesses of rotations and translations span 1e4, rigid bodies and lines 1e5
    np.testing.assert_allclose(found["values"][lines], exact, atol=1e-8 * np.abs(exact).max(), rtol=1e-7)


def test_it_is_what_an_ideal_rig_measures(service: Any, beam: str) -> None:
    analyser = {"frequency_max": 800.0, "n_lines": 101}
    rig = {"drive": "1:+Y", "responses": ASKED["responses"], "analyser": analyser}
    body = {"structure_id": beam, "rig_id": service.post("/v1/rigs", rig)["id"], "route": "expected"}
    id = service.result_of("/v1/measurements", body)
    measured = np.load(io.BytesIO(service.request("GET", f"/v1/measurements/{id}/arrays").content))
    np.testing.assert_allclose(frf(service, beam)["values"], measured["values"], rtol=1e-9)  # rounding


def test_what_a_structure_declares_beside_its_elements_is_in_it(service: Any) -> None:
    mass = {"kind": "extra_mass", "at": "11:+Y", "parameters": {"mass": 0.5}}
    plain = {"kind": "beam", "length": 1.5, "n_elements": 20}
    plain |= {"section": {"area": 5e-4, "second_moment": 4.1667e-9}}
    plain |= {"material": {"modulus": 2.09e11, "density": 7800.0}}
    bare = service.post("/v1/structures", plain)["id"]
    loaded = service.post("/v1/structures", plain | {"effects": [mass]})["id"]
    points = {"drive": "11:+Y", "responses": ["11:+Y"], "kind": "receptance"}
    # a mass on the drive point adds its dynamic stiffness: 1/alpha' = 1/alpha - omega^2 m
    before, after = frf(service, bare, **points), frf(service, loaded, **points)
    omega = 2 * np.pi * before["freq"][:, None, None]
    np.testing.assert_allclose(
        1 / after["values"], 1 / before["values"] - omega**2 * 0.5, rtol=1e-6, atol=1e-6 * omega.max() ** 2
    )


@pytest.mark.parametrize(
    ("changes", "code", "word"),
    [
        ({"drive": "99:+Y"}, "unknown_dof", "99"),
        ({"drive": "1+Y"}, "invalid_input", "1+Y"),
        ({"drive": "1:+RZ"}, "invalid_input", "rotation"),
        ({"responses": ["1:+Y", "1:-Y"]}, "invalid_input", "twice"),
        ({"responses": []}, "invalid_request", "responses"),
        ({"n_lines": 1_000_001}, "invalid_input", "n_lines"),
        (
            {"n_lines": 20_001, "responses": [f"{n}:+Y" for n in range(1, 13)]},
            "invalid_input",
            "expected route",
        ),
        ({"n_lines": 10**30}, "invalid_input", "n_lines"),
        ({"n_lines": -5}, "invalid_input", "n_lines"),
        ({"frequency_max": "nan"}, "invalid_input", "frequency_max"),
        ({"frequency_max": -1.0}, "invalid_input", "frequency_max"),
        ({"kind": "compliance"}, "invalid_request", "receptance"),
        ({"nonsense": 1}, "invalid_request", "nonsense"),
    ],
)
def test_what_cannot_be_is_refused_by_name(
    service: Any, beam: str, changes: dict[str, Any], code: str, word: str
) -> None:
    reply = service.request("GET", f"/v1/structures/{beam}/frf", params=ASKED | changes)
    assert 400 <= reply.status_code < 500, reply.text
    assert reply.json()["code"] == code
    assert word in reply.text


def test_a_large_structure_is_not_waited_for(service: Any) -> None:
    large = {"kind": "beam", "length": 1.5, "n_elements": 600}
    large |= {"section": {"area": 5e-4, "second_moment": 4.1667e-9}}
    large |= {"material": {"modulus": 2.09e11, "density": 7800.0}}
    id = service.post("/v1/structures", large)["id"]
    reply = service.request("GET", f"/v1/structures/{id}/frf", params=ASKED)
    assert reply.status_code == 422
    assert "1202" in reply.text


def test_every_catalogued_structure_is_small_enough(service: Any) -> None:
    for name in STRUCTURES:
        id = service.post("/v1/structures", {"kind": "catalogue", "name": name})["id"]
        dof = {"cantilever": "2:+Y", "plate": "1:+Z"}.get(name, "1:+Y")
        found = frf(service, id, drive=dof, responses=[dof])
        assert np.isfinite(found["values"]).all()
