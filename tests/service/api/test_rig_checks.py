"""Suspensions and checks over HTTP."""

from typing import Any

import pytest

BANDS = {"at": ["1:+Y", "21:+Y"], "stiffness": 100.0, "loss_factor": 0.05}


def test_a_suspension_is_declared_kept_and_checked(service: Any, beam: str) -> None:
    body = {"drive": "1:+Y", "responses": ["1:+Y", "7:+Y"], "suspension": BANDS}
    rig = service.post("/v1/rigs", body)["id"]
    assert service.get(f"/v1/rigs/{rig}")["suspension"] == BANDS
    found = service.get(f"/v1/rigs/{rig}/checks", params={"structure_id": beam})
    (check,) = [one for one in found["checks"] if one["name"] == "suspension"]
    assert check["fulfilled"] is True
    # (4.730 / L)^2 sqrt(E I / rho A) / 2 pi of the free beam; the bands lift it by k phi^2 / omega^2, 0.3 %
    assert check["figures"]["first_elastic_frequency"] == pytest.approx(23.65 * 1.003, rel=1e-3)
    # sqrt(6 k / M) of rocking
    assert check["figures"]["highest_rigid_frequency"] == pytest.approx(1.612, rel=0.01)
    measured = service.result_of(
        "/v1/measurements", {"structure_id": beam, "rig_id": rig, "route": "expected", "seed": 1}
    )
    assert service.get(f"/v1/measurements/{measured}")["id"] == measured


def test_bands_at_two_places_are_declared_as_one_effect(service: Any) -> None:
    effect = {
        "kind": "suspension",
        "at": {"dofs": ["1:+Y", "21:+Y"]},
        "parameters": {"stiffness": 100.0, "loss_factor": 0.05},
    }
    body = {"drive": "1:+Y", "responses": ["1:+Y", "7:+Y"], "effects": [effect]}
    rig = service.post("/v1/rigs", body)["id"]
    assert service.get(f"/v1/rigs/{rig}")["effects"] == [effect]


def test_a_rig_without_a_suspension_says_so(service: Any, rig: str, beam: str) -> None:
    assert service.get(f"/v1/rigs/{rig}")["suspension"] == {"at": [], "stiffness": 0.0, "loss_factor": 0.0}
    found = service.get(f"/v1/rigs/{rig}/checks", params={"structure_id": beam})
    assert all(check["fulfilled"] for check in found["checks"])


@pytest.mark.parametrize(
    "wrong",
    [
        {"at": []},
        {"at": ["1:+RZ"]},
        {"at": ["1:+Y", "1:-Y"]},
        {"at": ["somewhere"]},
        {"stiffness": -1.0},
        {"stiffness": None},
        {"loss_factor": 2.0},
        {"colour": "red"},
    ],
    ids=str,
)
def test_a_suspension_that_cannot_be_is_refused(service: Any, wrong: dict[str, Any]) -> None:
    body = {"drive": "1:+Y", "responses": ["1:+Y"], "suspension": BANDS | wrong}
    reply = service.request("POST", "/v1/rigs", json=body)
    assert reply.status_code == 422
    assert reply.headers["content-type"] == "application/problem+json"


def test_checks_need_a_structure_that_is_there_and_has_the_bands_dofs(service: Any, beam: str) -> None:
    body = {"drive": "1:+Y", "responses": ["1:+Y"], "suspension": BANDS | {"at": ["99:+Y"]}}
    rig = service.post("/v1/rigs", body)["id"]
    for params, status in (({}, 422), ({"structure_id": "nowhere"}, 404), ({"structure_id": beam}, 422)):
        reply = service.request("GET", f"/v1/rigs/{rig}/checks", params=params)
        assert reply.status_code == status, reply.text
        assert reply.headers["content-type"] == "application/problem+json"
