"""Updates of all coefficients at once over HTTP, and what data identify."""

import io
import sys
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
    assert found["kind"] == "iterative"
    assert told["rank"] == found["rank"]
    assert found["history"][0]["macros"][0] == {"part": "mass", "members": [1]}
    assert len(found["history"][0]["step"]) == len(found["history"][0]["coefficients"]) == 40
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
    assert job["error"]["context"] == {"field": "macros", "value": 40, "allowed": {"maximum": 36}}
    body = asked(beam, few, underdetermined="regularised")
    update = service.get(f"/v1/updates/{service.result_of('/v1/updates', body)}")
    assert update["converged"]
    nothing = [one for one in update["identifiability"]["directions"] if one["standard_error"] is None]
    assert len(nothing) == 40 - update["rank"]


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"prior": "flat"}, "prior"),
        ({"underdetermined": "maybe"}, "underdetermined"),
        ({"max_step": 0.2}, "max_step"),
    ],
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


def test_draws_come_back_with_what_they_are_of(service: Any, beam: str, stiffer: str) -> None:
    body = asked(beam, modes_of(service, stiffer, 4, seed=3), samples=100, seed=5, prior="range")
    body["parameterisation"] = {"macros": [[11, 12]], "parts": ["stiffness"]}
    id = service.result_of("/v1/updates", body)
    told = service.get(f"/v1/updates/{id}")["posterior"]
    (one,) = told["coefficients"]
    assert (one["part"], one["members"]) == ("stiffness", [11, 12])
    assert one["interval"][0] < one["mean"] < one["interval"][1]
    assert one["effective"] <= told["n_draws"]
    reply = service.request("GET", f"/v1/updates/{id}/sample")
    assert reply.status_code == 200, reply.text
    with np.load(io.BytesIO(reply.content)) as file:
        assert file["draws"].shape == (told["n_draws"], 1)
        assert file["draws"].mean() == pytest.approx(one["mean"])
        assert file["coefficients"].tolist() == ["stiffness of 11, 12"]
        assert len(file["log_density"]) == told["n_draws"] >= 100


def test_an_update_without_draws_has_none(service: Any, found: Any) -> None:
    assert found["posterior"] is None
    assert service.request("GET", f"/v1/updates/{found['id']}/sample").status_code == 404


def test_draws_without_the_extra_are_refused_before_the_work(
    service: Any, beam: str, stiffer: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "emcee", None)
    problem = service.post("/v1/updates", asked(beam, modes_of(service, stiffer, 4), samples=10), status=501)
    assert (problem["code"], problem["context"]["field"]) == ("missing_extra", "samples")


@pytest.mark.parametrize("method", ["inverse_eigensensitivity", "zhang_sensitivity", "berman_nagy"])
def test_other_methods_have_no_draws(service: Any, beam: str, stiffer: str, method: str) -> None:
    body = asked(beam, modes_of(service, stiffer, 4), samples=10) | {"method": method}
    if method == "berman_nagy":
        del body["parameterisation"]
    problem = service.post("/v1/updates", body, status=422)
    assert problem["context"]["field"] == "samples"
