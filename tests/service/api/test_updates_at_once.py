"""Updates of all coefficients at once over HTTP, and what data identify."""

import io
from typing import Any

import numpy as np
import pytest

SENSORS = [f"{n}:+Y" for n in range(1, 22, 2)]


@pytest.fixture(scope="module")
def stiffer(service: Any, beam: str) -> str:
    """The beam with two stiffer members."""
    changes = [{"members": [11, 12], "property": "modulus", "factor": 1.5}]
    return str(service.post(f"/v1/structures/{beam}/changes", {"changes": changes})["id"])


def modes_of(service: Any, structure: str, count: int, seed: int | None = None) -> str:
    body: dict[str, Any] = {"count": count, "dofs": SENSORS}
    if seed is not None:
        body |= {"noise": {"eigenvalue": 0.005, "eigenvector": 0.05, "distribution": "uniform"}, "seed": seed}
    return str(service.post(f"/v1/structures/{structure}/synthetic-modes", body)["id"])


def asked(beam: str, modes: str, **options: Any) -> dict[str, Any]:
    return {
        "structure_id": beam,
        "modal_model_id": modes,
        "method": "one_shot",
        "parameterisation": {"macros": "each"},
        "options": options,
    }


@pytest.fixture(scope="module")
def found(service: Any, beam: str, stiffer: str) -> Any:
    """An update from noisy modes."""
    body = asked(beam, modes_of(service, stiffer, 8, seed=3))
    return service.get(f"/v1/updates/{service.result_of('/v1/updates', body)}")


def test_wrong_members_are_found_among_all(found: Any) -> None:
    assert found["converged"]
    assert found["iterations"]["location"] == 0
    assert {11, 12} <= set(found["suspected"]["stiffness"])
    assert len(found["coefficients"]["mass"]) == len(found["coefficients"]["stiffness"]) == 20


def test_every_coefficient_has_an_interval_and_directions_are_named(found: Any) -> None:
    for part in ("mass", "stiffness"):
        assert len(found["intervals"][part]) == 20
        assert all(0.05 <= low <= high <= 10.0 for low, high in found["intervals"][part].values())
    told = found["identifiability"]
    assert told["rank"] == found["rank"]
    assert len(told["singular_values"]) == 40
    assert told["directions"], "eight noisy modes do not tell 40 coefficients apart"
    for direction in told["directions"]:
        assert direction["words"].endswith("these data")
        assert direction["shares"]


def test_the_covariance_belongs_to_the_intervals(service: Any, found: Any) -> None:
    reply = service.request("GET", f"/v1/updates/{found['id']}/covariance")
    assert reply.status_code == 200, reply.text
    with np.load(io.BytesIO(reply.content)) as file:
        arrays = dict(file)
    assert arrays["covariance"].shape == (40, 40)
    assert arrays["coefficients"][0] == "mass of 1"
    np.testing.assert_array_equal(arrays["intervals"][0], found["intervals"]["mass"]["1"])


def test_an_update_of_matrices_has_no_covariance(service: Any, beam: str, stiffer: str) -> None:
    body = {"structure_id": beam, "modal_model_id": modes_of(service, stiffer, 6), "method": "baruch"}
    id = service.result_of("/v1/updates", body)
    reply = service.request("GET", f"/v1/updates/{id}/covariance")
    assert reply.status_code == 404
    assert "coefficients" in reply.json()["detail"]


def test_too_few_modes_fail_the_job_with_the_count_or_are_regularised(
    service: Any, beam: str, stiffer: str
) -> None:
    few = modes_of(service, stiffer, 3)
    job = service.get(f"/v1/jobs/{service.post('/v1/updates', asked(beam, few), status=202)['id']}")
    assert job["state"] == "failed"
    assert job["error"]["code"] == "underdetermined"
    assert job["error"]["context"] == {"field": "macros", "value": 40, "allowed": "<= 36"}
    body = asked(beam, few, few_rows="regularised")
    update = service.get(f"/v1/updates/{service.result_of('/v1/updates', body)}")
    assert update["converged"]
    nothing = [one for one in update["identifiability"]["directions"] if one["standard_error"] is None]
    assert len(nothing) == 40 - update["rank"]


@pytest.mark.parametrize(
    ("options", "field"),
    [({"prior": "flat"}, "prior"), ({"few_rows": "maybe"}, "few_rows"), ({"max_step": 0.2}, "max_step")],
)
def test_options_that_there_are_not_are_refused_by_name(
    service: Any, beam: str, stiffer: str, options: dict[str, Any], field: str
) -> None:
    body = asked(beam, modes_of(service, stiffer, 3), **options)
    assert service.post("/v1/updates", body, status=422)["context"]["field"] == field


def test_the_catalogue_has_the_choices(service: Any) -> None:
    listed = {one["kind"]: one for one in service.get("/v1/catalog/updating-methods")}
    assert listed["one_shot"]["parameters"]["prior"]["choices"] == ["sparse", "common", "range"]
    assert "suspect_threshold" not in listed["one_shot"]["parameters"]
    assert "prior" not in listed["inverse_eigensensitivity"]["parameters"]
