"""Further tests over HTTP: sent with a diagnosis, proposed by it, and run where the rig is ours."""

import io
from typing import Any

import numpy as np
import pytest

SECTION = {"area": 5e-4, "second_moment": 4.1667e-9}
STEEL = {"modulus": 2.09e11, "density": 7800.0}
DAMPING = {"law": "structural", "stiffness_coefficient": 0.008, "mass_coefficient": 100.0}
ANALYSER = {"frequency_max": 300.0, "n_lines": 81}
NODE_SUSPECTS = ["extra_mass", "force_transducer_mass"]  # alike at the drive point
HIDDEN = {"kind": "extra_mass", "at": "1:+Y", "parameters": {"mass": 0.02}}


@pytest.fixture(scope="module")
def beam(service: Any) -> str:
    """A free beam of six elements, four modes in the band."""
    body = {"kind": "beam", "length": 1.2, "n_elements": 6, "section": SECTION, "material": STEEL}
    return str(service.post("/v1/structures", body | {"damping": DAMPING})["id"])


@pytest.fixture(scope="module")
def small(service: Any) -> str:
    """A rig of four fixed accelerometers."""
    body = {
        "drive": "1:+Y",
        "responses": ["1:+Y", "3:+Y", "4:+Y", "7:+Y"],
        "analyser": ANALYSER,
        "noise": {"force": 1e-4, "response": 1e-4},
    }
    return str(service.post("/v1/rigs", body)["id"])


@pytest.fixture(scope="module")
def first(service: Any, beam: str, small: str) -> str:
    """A test of the beam with a mass at the drive point that no log book shows."""
    return measured(service, beam, small)


def measured(service: Any, beam: str, rig: str, *, seed: int = 1) -> str:
    body = {"structure_id": beam, "rig_id": rig, "effects": [HIDDEN], "route": "drawn", "seed": seed}
    return str(service.result_of("/v1/measurements", body))


def asked(beam: str, measurement: str, **more: Any) -> dict[str, Any]:
    return {"structure_id": beam, "measurement_id": measurement, "suspects": NODE_SUSPECTS, **more}


def refused(service: Any, body: dict[str, Any], *, status: int = 422) -> Any:
    reply = service.request("POST", "/v1/diagnoses", json=body)
    assert reply.status_code == status, reply.text
    assert reply.headers["content-type"] == "application/problem+json"
    return reply.json()


def test_what_one_test_cannot_tell_is_told_by_a_second(
    service: Any, beam: str, small: str, first: str
) -> None:
    found = service.get(f"/v1/diagnoses/{service.result_of('/v1/diagnoses', asked(beam, first))}")
    assert found["verdict"] == "ambiguous"
    proposed = found["next_test"]
    assert set(proposed["separates"]) == set(NODE_SUSPECTS)
    assert proposed["expected_separation"] > 5
    changed = proposed["change"]
    assert "drive" in changed

    rig = service.get(f"/v1/rigs/{small}")
    body = {name: rig[name] for name in ("responses", "noise")} | {"drive": changed["drive"]}
    body["analyser"] = ANALYSER
    moved = measured(service, beam, service.post("/v1/rigs", body)["id"], seed=2)
    follow_ups = [{"measurement_id": moved, "changed": changed}]
    id = service.result_of("/v1/diagnoses", asked(beam, first, follow_ups=follow_ups))
    found = service.get(f"/v1/diagnoses/{id}")
    assert found["verdict"] == "explained"
    assert (found["steps"][0]["effect"]["kind"], found["steps"][0]["effect"]["at"]) == ("extra_mass", "1:+Y")
    assert found["next_test"] is None
    assert found["follow_ups"] == follow_ups
    assert found["made_from"]["follow_up_1"] == moved
    assert service.request("GET", f"/v1/diagnoses/{id}/report").status_code == 200


def test_the_proposed_test_is_run_where_the_rig_is_ours(
    service: Any, beam: str, small: str, first: str
) -> None:
    id = service.result_of("/v1/diagnoses", asked(beam, first, act=True))
    found = service.get(f"/v1/diagnoses/{id}")
    assert found["verdict"] == "explained"
    assert found["steps"][0]["effect"]["kind"] == "extra_mass"
    (one,) = found["follow_ups"]
    earlier = service.get(f"/v1/diagnoses/{found['made_from']['earlier_1']}")
    assert earlier["verdict"] == "ambiguous"
    assert earlier["next_test"]["change"] == one["changed"]
    taken = service.get(f"/v1/measurements/{one['measurement_id']}")
    assert taken["rig"]["drive"] == one["changed"]["drive"]
    assert taken["made_from"]["first_measurement_id"] == first
    assert service.get(f"/v1/rigs/{taken['rig_id']}")["made_from"]["rig_id"] == small
    # Its owner may see how it was made, as of the first.
    assert service.get(f"/v1/measurements/{one['measurement_id']}/truth")["effects"] == [HIDDEN]


def test_the_same_question_is_answered_by_the_same_further_test(service: Any, beam: str, first: str) -> None:
    arrays = []
    for _ in "ab":
        id = service.result_of("/v1/diagnoses", asked(beam, first, act=True))
        (one,) = service.get(f"/v1/diagnoses/{id}")["follow_ups"]
        arrays.append(service.request("GET", f"/v1/measurements/{one['measurement_id']}/arrays").content)
    assert arrays[0] == arrays[1]


def uploaded(service: Any, rig: str, measurement: str) -> str:
    content = service.request("GET", f"/v1/measurements/{measurement}/arrays").content
    files = {"file": ("test.npz", io.BytesIO(content), "application/octet-stream")}
    reply = service.request("POST", "/v1/measurements/import", files=files, data={"rig_id": rig})
    assert reply.status_code == 201, reply.text
    return str(reply.json()["id"])


def test_a_test_from_elsewhere_cannot_be_repeated_here(
    service: Any, beam: str, small: str, first: str
) -> None:
    problem = refused(service, asked(beam, uploaded(service, small, first), act=True))
    assert problem["context"]["field"] == "act"


def test_an_upload_against_the_first_rig_is_read_with_what_was_changed(
    service: Any, beam: str, small: str, first: str
) -> None:
    louder = service.get(f"/v1/rigs/{small}")
    body = {name: louder[name] for name in ("drive", "responses", "noise")}
    body["analyser"] = ANALYSER | {"excitation": {"level": 3.0}}
    made = measured(service, beam, service.post("/v1/rigs", body)["id"], seed=3)
    follow_ups = [{"measurement_id": uploaded(service, small, made), "changed": {"level_factor": 3.0}}]
    id = service.result_of("/v1/diagnoses", asked(beam, first, follow_ups=follow_ups))
    # Read at the first level its forces would be nine times too strong.
    assert service.get(f"/v1/diagnoses/{id}")["gaps"]["after"]["force"] == pytest.approx(1.0, abs=0.3)


@pytest.mark.parametrize(
    ("changed", "field"),
    [
        ({"level_factor": -1.0}, "changed.level_factor"),
        ({"drive": "nowhere"}, "changed.drive"),
        ({"drive": "6:+Y"}, "follow_ups.changed.drive"),
        ({"window": "triangular"}, None),
        ({"added_mass": {"at": "1:+Y", "mass": 0.0}}, "added_mass.mass"),
    ],
    ids=str,
)
def test_a_change_that_cannot_be_is_refused_before_the_work(
    service: Any, beam: str, first: str, changed: dict[str, Any], field: str | None
) -> None:
    follow_ups = [{"measurement_id": first, "changed": changed}]
    problem = refused(service, asked(beam, first, follow_ups=follow_ups))
    assert problem["code"] == "invalid_input"
    assert field is None or problem["context"]["field"] == field


@pytest.mark.parametrize(
    "changed", [{"colour": "red"}, {"level_factor": "3"}, {"added_mass": {"at": "1:+Y"}}], ids=str
)
def test_a_change_that_is_none_is_refused_by_name(service: Any, beam: str, first: str, changed: Any) -> None:
    follow_ups = [{"measurement_id": first, "changed": changed}]
    problem = refused(service, asked(beam, first, follow_ups=follow_ups))
    assert problem["context"]["field"].startswith("body.follow_ups.0.changed")


def test_a_further_test_that_is_not_there_is_not_found(service: Any, beam: str, first: str) -> None:
    refused(service, asked(beam, first, follow_ups=[{"measurement_id": "none"}]), status=404)


def test_the_arrays_are_those_of_the_first_test(service: Any, beam: str, first: str) -> None:
    follow_ups = [{"measurement_id": first}]
    id = service.result_of("/v1/diagnoses", asked(beam, first, follow_ups=follow_ups))
    arrays = np.load(io.BytesIO(service.request("GET", f"/v1/diagnoses/{id}/arrays").content))
    assert arrays["measured"].shape == (81, 4, 1)
