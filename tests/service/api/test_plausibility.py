"""Replies name what is surely a slip in what was sent, at once."""

from typing import Any

STEEL = {"modulus": 2.1e11, "density": 7800.0}
BAR = {"area": 5e-4, "second_moment": 4.2e-9}


def test_a_structure_with_a_slip_is_made_and_warned_of(service: Any) -> None:
    body = {"kind": "beam", "length": 1.5, "n_elements": 10, "section": BAR}
    made = service.post("/v1/structures", body | {"material": STEEL | {"modulus": 209.0}})
    (warning,) = made["warnings"]
    assert warning.keys() == {"code", "message", "field"}
    assert (warning["code"], warning["field"]) == ("modulus", "modulus")
    assert service.get(f"/v1/structures/{made['id']}")["warnings"] == made["warnings"]
    assert service.post("/v1/structures", body | {"material": STEEL})["warnings"] == []


def test_one_average_is_warned_of_in_the_rig_and_in_its_measurement(service: Any, beam: str) -> None:
    rig = service.post("/v1/rigs", {"drive": "1:+Y", "responses": ["1:+Y"], "analyser": {"averages": 1}})
    assert [warning["field"] for warning in rig["warnings"]] == ["analyser.averages"]
    test = service.result_of("/v1/measurements", {"structure_id": beam, "rig_id": rig["id"]})
    codes = [warning["code"] for warning in service.get(f"/v1/measurements/{test}")["warnings"]]
    assert codes == ["one_average"]
