"""Exciters, stingers and force gauges over HTTP."""

from typing import Any

import pytest

RIG = {"drive": "1:+Y", "responses": ["1:+Y", "7:+Y"]}
EXCITER = {
    "kind": "shaker",
    "armature_mass": 0.05,
    "suspension_stiffness": 2e4,
    "suspension_damping": 3.0,
    "coil": {"force_factor": 7.0, "resistance": 1.5, "inductance": 3e-4},
    "amplifier": "voltage",
}
ROD = {"diameter": 4e-3, "length": 50e-3, "modulus": 2.07e11, "density": 7850.0}
SPRINGS = {"axial_stiffness": 2e6, "bending_stiffness": 20.0, "lateral_stiffness": 2.4e4}
GAUGE = {"mass_below": 0.01, "mass_cancelled": True, "stiffness": 4e7}


@pytest.mark.parametrize("stinger", [ROD, SPRINGS, None])
def test_a_shaker_with_all_it_has_is_declared_kept_and_measures(
    service: Any, beam: str, stinger: dict[str, float] | None
) -> None:
    body = RIG | {"exciter": EXCITER, "stinger": stinger, "force_transducer": GAUGE}
    kept = service.get(f"/v1/rigs/{service.post('/v1/rigs', body)['id']}")
    assert {name: kept[name] for name in body} == body
    again = {name: kept[name] for name in ("drive", "responses", "exciter", "stinger", "force_transducer")}
    rig = service.post("/v1/rigs", again)["id"]
    measured = service.result_of(
        "/v1/measurements", {"structure_id": beam, "rig_id": rig, "route": "expected", "seed": 1}
    )
    assert service.get(f"/v1/measurements/{measured}")["id"] == measured


@pytest.mark.parametrize(
    "wrong",
    [
        {"exciter": {"amplifier": "voltage"}},
        {"exciter": {"amplifier": "loud"}},
        {"exciter": {"coil": {"force_factor": 7.0}}},
        {"exciter": {"coil": {"force_factor": 7.0, "resistance": 0.0}}},
        {"exciter": {"suspension_stiffness": -1.0}},
        {"stinger": {}},
        {"stinger": {"diameter": 4e-3}},
        {"stinger": ROD | SPRINGS},
        {"stinger": ROD | {"length": -1.0}},
        {"stinger": {"axial_stiffness": 0.5}},
        {"stinger": {"lateral_stiffness": 1e4}},
        {"force_transducer": {"stiffness": -4e7}},
    ],
    ids=str,
)
def test_hardware_that_cannot_be_is_refused(service: Any, wrong: dict[str, Any]) -> None:
    reply = service.request("POST", "/v1/rigs", json=RIG | wrong)
    assert reply.status_code == 422
    assert reply.headers["content-type"] == "application/problem+json"


def test_the_stinger_s_own_resonances_are_checked_against_the_band(service: Any, beam: str) -> None:
    """The long rod of the 1992 thesis, appendix D: 1,515 Hz by its rounded constant, and 2,630 Hz."""
    rod = {"diameter": 1.5e-3, "length": 67e-3, "modulus": 2.07e11, "density": 7850.0}
    body = RIG | {"exciter": {"armature_mass": 0.02}, "stinger": rod, "analyser": {"frequency_max": 1600.0}}
    rig = service.post("/v1/rigs", body)["id"]
    found = service.get(f"/v1/rigs/{rig}/checks", params={"structure_id": beam})["checks"]
    bending, axial = (
        next(one for one in found if one["name"] == name) for name in ("stinger_bending", "stinger_axial")
    )
    assert bending["figures"]["bending_frequency"] == pytest.approx(1515 * 0.890 / 0.883, rel=1e-3)
    assert not bending["fulfilled"]
    assert axial["figures"]["axial_frequency"] == pytest.approx(2630, abs=1.0)
    assert axial["fulfilled"]
