"""What may differ a little: said in a request, told in the reply."""

from typing import Any

from tests.bodies import free_beam

BEAM = free_beam(6)
RIG = {
    "drive": "1:+Y",
    "responses": ["1:+Y", "3:+Y", "4:+Y", "5:+Y", "7:+Y"],
    "noise": {"force": 1e-4, "response": 1e-4},
    "accelerometers": {"mass": 0.02, "roving": True},
    "analyser": {"frequency_max": 400.0, "n_lines": 161, "averages": 50},
}
TRUE = [
    {"kind": "extra_mass", "at": "4:+Y", "parameters": {"mass": 0.05}},
    {"kind": "stiffness_error", "at": None, "parameters": {"factor": 1.004}},
    {"kind": "gain_error", "at": None, "parameters": {"factor": 0.997}},
]


def test_what_is_tolerated_is_not_named_and_its_size_is_told(service: Any) -> None:
    model, rig = (
        service.post(f"/v1/{kind}", body)["id"] for kind, body in (("structures", BEAM), ("rigs", RIG))
    )
    made = {"structure_id": model, "rig_id": rig, "effects": TRUE, "route": "drawn", "seed": 1}
    asked = {
        "structure_id": model,
        "measurement_id": service.result_of("/v1/measurements", made),
        "suspects": ["extra_mass", "stiffness_error", "gain_error"],
        "tolerances": {"modulus": 0.003, "sensitivity": 0.005, "modal_loss_factor": 0.2},
    }
    found = service.get(f"/v1/diagnoses/{service.result_of('/v1/diagnoses', asked)}")
    assert found["verdict"] == "explained"
    (step,) = found["steps"]
    assert (step["effect"]["kind"], step["effect"]["at"]) == ("extra_mass", "4:+Y")
    keys = {"name", "at", "mode", "value", "standard_error", "tolerance", "unit"}
    assert all(set(one) == keys for one in found["tolerated"])
    told = {one["name"]: one for one in found["tolerated"] if one["mode"] is None}
    for name, true in (("modulus", 1.004), ("sensitivity", 0.997)):
        assert abs(told[name]["value"] - true) < 4 * told[name]["standard_error"]  # four standard errors
    modes = [one["mode"] for one in found["tolerated"] if one["name"] == "modal_loss_factor"]
    assert modes == [1, 2, 3, 4, 5]  # below 500 Hz, 1.25 times the band
