"""What a diagnosis is asked with: taken, converted, or refused by a problem that names it."""

import io
from typing import Any

import numpy as np
import pytest

from tests.bodies import free_beam

RIG = {
    "drive": "1:+Y",
    "responses": ["1:+Y", "3:+Y", "4:+Y", "5:+Y", "7:+Y"],
    "noise": {"force": 1e-4, "response": 1e-4},
    "analyser": {"frequency_max": 400.0, "n_lines": 161, "averages": 50, "excitation": {"level": 1.0}},
}
BEAM = free_beam(6)
HIDDEN = {"kind": "extra_mass", "at": "4:+Y", "parameters": {"mass": 0.05}}
FEW = ["extra_mass", "response_noise"]


@pytest.fixture(scope="module")
def model(service: Any) -> str:
    return str(service.post("/v1/structures", BEAM)["id"])


@pytest.fixture(scope="module")
def rig_id(service: Any) -> str:
    return str(service.post("/v1/rigs", RIG)["id"])


@pytest.fixture(scope="module")
def arrays(service: Any, model: str, rig_id: str) -> dict[str, Any]:
    """What a test with a hidden mass measured."""
    body = {"structure_id": model, "rig_id": rig_id, "effects": [HIDDEN], "route": "drawn", "seed": 1}
    id = service.result_of("/v1/measurements", body)
    return dict(np.load(io.BytesIO(service.request("GET", f"/v1/measurements/{id}/arrays").content)))


def imported(service: Any, rig_id: str | None, arrays: dict[str, Any], status: int = 201) -> Any:
    file = io.BytesIO()
    np.savez(file, **arrays)
    reply = service.request(
        "POST",
        "/v1/measurements/import",
        files={"file": ("test.npz", file.getvalue())},
        data={} if rig_id is None else {"rig_id": rig_id},
    )
    assert reply.status_code == status, reply.text
    return reply.json()


def refused(service: Any, body: dict[str, Any], code: str, field: str) -> dict[str, Any]:
    """Return the problem with which a diagnosis is refused before any work."""
    reply = service.request("POST", "/v1/diagnoses", json=body)
    assert reply.headers["content-type"] == "application/problem+json"
    problem: dict[str, Any] = reply.json()
    assert (reply.status_code, problem["code"], problem["context"].get("field")) == (422, code, field), (
        problem
    )
    return problem


def diagnosed(service: Any, body: dict[str, Any]) -> Any:
    return service.get(f"/v1/diagnoses/{service.result_of('/v1/diagnoses', body)}")


def asked(model: str, measurement: Any, **more: Any) -> dict[str, Any]:
    return {"structure_id": model, "measurement_id": measurement["id"], "suspects": FEW, **more}


def without(arrays: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: array for name, array in arrays.items() if name not in names}


def test_what_is_located_comes_with_numbers_and_words(
    service: Any, model: str, rig_id: str, arrays: dict[str, Any]
) -> None:
    found = diagnosed(service, asked(model, imported(service, rig_id, arrays)))
    assert found["verdict"] == "explained"
    located = found["located"]
    for name in ("bands", "dofs", "modes", "words"):
        assert located[name], name
    assert [one["mode"] for one in located["mode_shifts"]][:2] == [1, 2]
    # the mass slows down the modes that move there: node 4 of 7 is in the middle, where odd modes do
    assert located["mode_shifts"][0]["frequency_shift"] < -0.001
    assert {one["dof"] for one in located["responses"]} == set(RIG["responses"])
    assert located["level_dependence"] is None
    assert found["notes"] == []


def test_dofs_that_the_model_lacks_are_refused(service: Any, rig_id: str, arrays: dict[str, Any]) -> None:
    small = service.post("/v1/structures", BEAM | {"n_elements": 4})["id"]
    problem = refused(service, asked(small, imported(service, rig_id, arrays)), "unknown_dof", "dof")
    assert "7" in problem["detail"]


@pytest.mark.parametrize("kind", ["mobility", "receptance"])
def test_other_kinds_of_frfs_are_converted_and_said_so(
    service: Any, model: str, rig_id: str, arrays: dict[str, Any], kind: str
) -> None:
    omega = 2 * np.pi * arrays["freq"][1:]
    size = 1 / (1j * omega) ** (1 if kind == "mobility" else 2)
    other = {name: value[1:] if value.ndim and len(value) == 161 else value for name, value in arrays.items()}
    other["values"] = other["values"] * size[:, None, None]
    other["response_spectrum"] = other["response_spectrum"] * np.abs(size[:, None]) ** 2
    found = diagnosed(service, asked(model, imported(service, rig_id, other | {"kind": np.array(kind)})))
    (step,) = found["steps"]
    assert (step["effect"]["kind"], step["effect"]["at"]) == ("extra_mass", "4:+Y")
    assert found["notes"] == [f"the FRFs are {kind}: compared as inertance, without 0 Hz"]


def test_an_unknown_kind_is_refused(service: Any, rig_id: str, arrays: dict[str, Any]) -> None:
    problem = imported(service, rig_id, arrays | {"kind": np.array("compliance")}, status=422)
    assert problem["context"]["field"] == "kind"


def test_frfs_in_other_units_show_as_gains_of_all_responses(
    service: Any, model: str, rig_id: str, arrays: dict[str, Any]
) -> None:
    # an npz says no unit: accelerations in g are 9.81 times too small, and are not named as something else
    in_g = arrays | {
        "values": arrays["values"] / 9.80665,
        "response_spectrum": arrays["response_spectrum"] / 9.80665**2,
    }
    found = diagnosed(service, asked(model, imported(service, rig_id, in_g)))
    assert found["verdict"] == "unexplained"
    amplitudes = [one["amplitude"] for one in found["located"]["responses"]]
    np.testing.assert_allclose(amplitudes, 1 / 9.80665, rtol=0.1)  # the hidden mass is in it too


@pytest.mark.parametrize("floor", [None, 0.01])
def test_without_coherence_scatter_or_a_noise_floor_is_the_random_error(
    service: Any, model: str, rig_id: str, arrays: dict[str, Any], floor: float | None
) -> None:
    bare = imported(service, rig_id, without(arrays, "coherence", "averages"))
    assert any(assumption["quantity"] == "random_error" for assumption in bare["assumed"])
    found = diagnosed(service, asked(model, bare, **({} if floor is None else {"noise_floor": floor})))
    (step,) = found["steps"]
    assert (step["effect"]["kind"], step["effect"]["at"]) == ("extra_mass", "4:+Y")
    mass = step["effect"]["parameters"]["mass"]
    assert abs(mass["value"] - 0.05) < 4 * mass["standard_error"]
    assert "response" not in found["gaps"]["after"]
    assert any("no usable coherence" in note for note in found["notes"])


@pytest.mark.parametrize("with_rig", [True, False])
def test_an_upload_that_declares_nothing_is_explained_by_its_effect(
    service: Any, model: str, arrays: dict[str, Any], with_rig: bool
) -> None:
    nothing = {"frequency_max": 400.0, "n_lines": 161, "averages": None, "excitation": None}
    rig = RIG | {"noise": None, "analyser": nothing}
    id = str(service.post("/v1/rigs", rig)["id"]) if with_rig else None
    test = imported(service, id, without(arrays, "averages"))
    (averages,) = (one for one in test["assumed"] if one["quantity"] == "averages")
    estimate, error = (float(text) for text in averages["value"].split(" +- "))
    # drawn with 50; 12 stretches of 5 FRFs: their scatter tells the error to a quarter
    assert abs(estimate - 50) < 3 * error + 0.05 * 50
    found = diagnosed(service, asked(model, test))
    (step,) = found["steps"]
    assert (step["effect"]["kind"], step["effect"]["at"]) == ("extra_mass", "4:+Y")
    assert found["verdict"] == "explained"
    assert any("not judged" in note for note in found["notes"])


def test_two_averages_ask_for_a_noise_floor_too(
    service: Any, model: str, rig_id: str, arrays: dict[str, Any]
) -> None:
    few = imported(service, rig_id, arrays | {"averages": np.array(2.0)})
    problem = refused(service, asked(model, few), "invalid_input", "averages")
    assert "noise floor" in problem["detail"]


@pytest.mark.parametrize("floor", [0.0, -0.1, 1.5])
def test_a_noise_floor_is_a_relative_error(
    service: Any, model: str, rig_id: str, arrays: dict[str, Any], floor: float
) -> None:
    body = asked(model, imported(service, rig_id, arrays), noise_floor=floor)
    refused(service, body, "invalid_request", "body.noise_floor")


def test_lines_at_uneven_distances_are_refused(service: Any, rig_id: str, arrays: dict[str, Any]) -> None:
    uneven = arrays["freq"] * (1 + 0.1 * np.linspace(0, 1, 161))
    problem = imported(service, rig_id, arrays | {"freq": uneven}, status=422)
    assert problem["context"]["field"] == "freq"


def test_another_frequency_axis_than_the_log_books_is_refused(
    service: Any, rig_id: str, arrays: dict[str, Any]
) -> None:
    shifted = arrays["freq"] + arrays["freq"][1] / 3  # between the lines of the rig
    problem = imported(service, rig_id, arrays | {"freq": shifted}, status=422)
    assert problem["context"]["field"] == "freq"


def test_a_single_frf_is_diagnosed_with_what_it_cannot_tell(
    service: Any, model: str, rig_id: str, arrays: dict[str, Any]
) -> None:
    one = {
        name: value[:, 2:3] if value.ndim > 1 else value[2:3] if name == "outputs" else value
        for name, value in arrays.items()
    }
    found = diagnosed(service, asked(model, imported(service, rig_id, one)))
    assert any("a single FRF" in note for note in found["notes"])
    assert any("lines are held out" in note for note in found["notes"])
    assert found["steps"][0]["effect"]["kind"] == "extra_mass"


def test_no_suspect_at_all_is_refused(service: Any, model: str, rig_id: str, arrays: dict[str, Any]) -> None:
    refused(
        service,
        asked(model, imported(service, rig_id, arrays)) | {"suspects": []},
        "invalid_request",
        "body.suspects",
    )


def test_an_unknown_suspect_is_refused(service: Any, model: str, rig_id: str, arrays: dict[str, Any]) -> None:
    body = asked(model, imported(service, rig_id, arrays)) | {"suspects": ["gremlins"]}
    refused(service, body, "invalid_input", "effect")


def test_suspects_that_have_no_place_on_this_rig_are_a_named_problem(
    service: Any, model: str, rig_id: str, arrays: dict[str, Any]
) -> None:
    one = {
        name: value[:, :1] if value.ndim > 1 else value[:1] if name == "outputs" else value
        for name, value in arrays.items()
    }
    body = asked(model, imported(service, rig_id, one)) | {"suspects": ["swapped_channels"]}
    job = service.get(f"/v1/jobs/{service.post('/v1/diagnoses', body, status=202)['id']}")
    assert job["state"] == "failed"
    assert (job["error"]["status"], job["error"]["context"]["field"]) == (422, "suspects")


def test_nothing_left_to_fit_is_a_named_problem(
    service: Any, model: str, rig_id: str, arrays: dict[str, Any]
) -> None:
    body = asked(model, imported(service, rig_id, arrays), hold_out={"dofs": RIG["responses"]})
    job = service.get(f"/v1/jobs/{service.post('/v1/diagnoses', body, status=202)['id']}")
    assert job["state"] == "failed"
    assert (job["error"]["status"], job["error"]["context"]["field"]) == (422, "hold_out")
