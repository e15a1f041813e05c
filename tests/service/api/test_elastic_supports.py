"""Supports that yield over HTTP: hidden, found and reported, put into a model, and refused by name."""

from typing import Any

import pytest

RIG = {
    "drive": "11:+Y",
    "responses": ["3:+Y", "7:+Y", "11:+Y", "15:+Y", "21:+Y"],
    "analyser": {"frequency_max": 250.0, "n_lines": 126},
    "noise": {"force": 1e-3, "response": 1e-3},
}
SOFT = {"kind": "rotational_elastic_support", "at": "1:+RZ", "parameters": {"flexibility": 2e-4}}


@pytest.fixture(scope="module")
def cantilever(service: Any) -> str:
    """A clamped beam's id."""
    return str(service.post("/v1/structures", {"kind": "catalogue", "name": "cantilever"})["id"])


@pytest.fixture(scope="module")
def rig_id(service: Any) -> str:
    """The id of a rig on it."""
    return str(service.post("/v1/rigs", RIG)["id"])


def test_a_clamp_that_turns_is_found_and_reported(service: Any, cantilever: str, rig_id: str) -> None:
    asked = {"structure_id": cantilever, "rig_id": rig_id, "effects": [SOFT], "seed": 2}
    test = service.result_of("/v1/measurements", asked)
    kinds = ["elastic_support", "rotational_elastic_support", "stiffness_error", "extra_mass"]
    found = service.result_of(
        "/v1/diagnoses", {"structure_id": cantilever, "measurement_id": test, "suspects": kinds}
    )
    (step,) = service.get(f"/v1/diagnoses/{found}")["steps"]
    assert (step["effect"]["kind"], step["effect"]["at"]) == (SOFT["kind"], "1:+RZ")
    # a few parts in a thousand: noise of 1e-3 over a hundred lines
    value = step["effect"]["parameters"]["flexibility"]["value"]
    assert value == pytest.approx(2e-4, rel=0.01)
    assert "rotational_elastic_support" in service.request("GET", f"/v1/diagnoses/{found}/report").text


@pytest.mark.parametrize(
    ("kind", "at", "allowed"),
    [
        ("elastic_support", "1:+RZ", ["1:+Y"]),
        ("elastic_support", "7:+Y", ["1:+Y"]),
        ("elastic_support", None, ["1:+Y"]),
        ("rotational_elastic_support", "1:+Y", ["1:+RZ"]),
        ("rotational_elastic_support", "99:+RZ", ["1:+RZ"]),
        ("rotational_elastic_support", {"members": [1]}, ["1:+RZ"]),
    ],
)
def test_what_the_model_does_not_hold_is_refused_with_what_it_holds(
    service: Any, cantilever: str, rig_id: str, kind: str, at: Any, allowed: list[str]
) -> None:
    body = {"structure_id": cantilever, "rig_id": rig_id, "effects": [{"kind": kind, "at": at}]}
    reply = service.request("POST", "/v1/measurements", json=body)
    assert reply.status_code == 422, reply.text
    context = reply.json()["context"]
    assert (context["field"], context["allowed"]) == ("at", allowed)


def test_a_free_beam_has_no_support_that_could_yield(service: Any, beam: str, rig_id: str) -> None:
    body = {"structure_id": beam, "rig_id": rig_id, "effects": [SOFT]}
    reply = service.request("POST", "/v1/measurements", json=body)
    assert reply.status_code == 422, reply.text
    assert reply.json()["context"]["allowed"] == []
