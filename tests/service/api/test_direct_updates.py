"""Direct updating methods over HTTP."""

import io
from typing import Any

import numpy as np
import pytest

SENSORS = [f"{n}:+Y" for n in range(1, 22, 2)]
ALL = [f"{n}:+{direction}" for n in range(1, 22) for direction in ("Y", "RZ")]


@pytest.fixture(scope="module")
def stiffer(service: Any, beam: str) -> str:
    """The beam with two stiffer members."""
    changes = [{"members": [11, 12], "property": "modulus", "factor": 1.5}]
    return str(service.post(f"/v1/structures/{beam}/changes", {"changes": changes})["id"])


def modes_at(service: Any, structure: str, dofs: list[str]) -> str:
    body = {"count": 6, "dofs": dofs}
    return str(service.post(f"/v1/structures/{structure}/synthetic-modes", body)["id"])


@pytest.fixture(scope="module")
def full(service: Any, stiffer: str) -> str:
    """Its modes at every DoF."""
    return modes_at(service, stiffer, ALL)


@pytest.fixture(scope="module")
def sparse(service: Any, stiffer: str) -> str:
    """Its modes at eleven DoFs."""
    return modes_at(service, stiffer, SENSORS)


def run(service: Any, beam: str, modes: str, method: str, **options: Any) -> Any:
    body = {"structure_id": beam, "modal_model_id": modes, "method": method, "options": options}
    return service.get(f"/v1/updates/{service.result_of('/v1/updates', body)}")


def arrays(service: Any, found: Any) -> dict[str, Any]:
    reply = service.request("GET", f"/v1/updates/{found['id']}/arrays")
    assert reply.status_code == 200, reply.text
    with np.load(io.BytesIO(reply.content)) as file:
        return dict(file)


@pytest.mark.parametrize("method", ["baruch", "berman_nagy"])
def test_a_correction_has_the_measured_modes_and_says_what_it_cost(
    service: Any, beam: str, full: str, method: str
) -> None:
    found = run(service, beam, full, method, n_modes=4)
    assert found["kind"] == "direct"
    assert found["converged"]
    assert found["coefficients"] == {}
    assert not {"structure_id", "iterations", "standard_errors", "suspected"} & found.keys()
    assert (found["method"], found["dofs"], found["n_modes"]) == (method, ALL, 4)
    assert found["reproduced"] < 1e-8
    assert 0.3 < found["connectivity_loss"]["stiffness"] < 1
    assert len(found["other_modes"]["after"]) == 42 - 2 - 4
    frequencies = {name: np.array(found["frequencies"][name]) for name in ("measured", "before", "after")}
    np.testing.assert_allclose(frequencies["after"][:4], frequencies["measured"][:4], rtol=1e-8)
    assert len(frequencies["after"]) == 6  # two were held back
    made = arrays(service, found)
    assert made["dofs"].tolist() == ALL
    np.testing.assert_allclose(made["stiffness"], made["stiffness"].T, rtol=1e-6, atol=1e-3)
    assert ("mass_error" in made) == (method == "berman_nagy")


@pytest.mark.parametrize(
    ("method", "matrix"), [("error_matrix", "stiffness"), ("modified_error_matrix", "force_balance")]
)
def test_error_location_points_at_the_stiffer_members(
    service: Any, beam: str, full: str, method: str, matrix: str
) -> None:
    found = run(service, beam, full, method)
    assert not found["converged"]
    assert found["frequencies"].keys() == {"measured", "before"}
    assert found["mac"].keys() == {"before"}
    assert found["other_modes"] is None
    ranked = found["dof_errors"][matrix]
    assert [one["error"] for one in ranked] == sorted((one["error"] for one in ranked), reverse=True)
    assert {one["dof"].split(":")[0] for one in ranked[:3]} <= {"11", "12", "13"}
    made = arrays(service, found)
    assert matrix in made or f"{matrix}_error" in made
    assert "mass" not in made


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"completion": "expansion", "expansion": {"kind": "serep", "parameters": {"modes": 6}}},
        {"completion": "guyan"},
        {"completion": {"kind": "dynamic", "parameters": {"frequency": 80.0}}},
    ],
)
def test_modes_at_some_dofs_are_completed_as_asked(
    service: Any, beam: str, sparse: str, options: dict[str, Any]
) -> None:
    direct = run(service, beam, sparse, "baruch", **options)
    reduced = options.get("completion", "expansion") != "expansion"
    assert len(direct["dofs"]) == (11 if reduced else 42)
    assert direct["connectivity_loss"].keys() == (set() if reduced else {"stiffness"})
    kind = options.get("expansion", options.get("completion", "dynamic"))
    assert (kind if isinstance(kind, str) else kind["kind"]) in direct["completion"]


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "no such method": ({"method": "guess"}, "method"),
    "a step that a direct method does not take": ({"options": {"max_step": 0.1}}, "max_step"),
    "coefficients": ({"parameterisation": {"macros": [[1, 2]]}}, "parameterisation"),
    "no such completion": ({"options": {"completion": "guess"}}, "completion"),
    "no such expansion": ({"options": {"expansion": "guess"}}, "expansion"),
    "both at once": ({"options": {"completion": "guyan", "expansion": "serep"}}, "expansion"),
    "numbers without a reduction": (
        {"options": {"completion": {"kind": "expansion", "parameters": {"modes": 3}}}},
        "modes",
    ),
    "matrices for coefficients": (
        {"method": "inverse_eigensensitivity", "options": {"completion": "guyan"}},
        "completion",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_a_method_cannot_do_is_refused_at_once(service: Any, beam: str, sparse: str, case: str) -> None:
    wrong, field = REFUSED[case]
    body = {"structure_id": beam, "modal_model_id": sparse, "method": "baruch"} | wrong
    reply = service.request("POST", "/v1/updates", json=body)
    assert reply.status_code == 422, reply.text
    assert reply.json()["context"]["field"] == field


def test_more_modes_than_there_are_fail_the_job_by_name(service: Any, beam: str, sparse: str) -> None:
    body = {"structure_id": beam, "modal_model_id": sparse, "method": "baruch", "options": {"n_modes": 7}}
    job = service.get(f"/v1/jobs/{service.post('/v1/updates', body, status=202)['id']}")
    assert job["state"] == "failed"
    assert job["error"]["context"] == {
        "field": "n_modes",
        "value": 7,
        "allowed": {"minimum": 1, "maximum": 6},
    }


def test_an_update_of_coefficients_has_no_matrices(service: Any, beam: str, sparse: str) -> None:
    found = run(service, beam, sparse, "inverse_eigensensitivity", max_iterations=1)
    assert found["kind"] == "iterative"
    reply = service.request("GET", f"/v1/updates/{found['id']}/arrays")
    assert reply.status_code == 404
    assert "coefficients" in reply.json()["detail"]


@pytest.mark.parametrize("method", ["zhang_sensitivity", "zhang_subspace"])
def test_members_are_suspected_by_one_step(service: Any, beam: str, sparse: str, method: str) -> None:
    body = {
        "structure_id": beam,
        "modal_model_id": sparse,
        "method": method,
        "parameterisation": {"macros": [[n, n + 1] for n in range(1, 20, 2)], "parts": ["stiffness"]},
        "options": {"suspect_threshold": 0.2},
    }
    found = service.get(f"/v1/updates/{service.result_of('/v1/updates', body)}")
    assert found["suspected"] == {"stiffness": [11, 12]}
    assert (found["kind"], found["method"]) == ("error_location", method)
    assert not {"structure_id", "coefficients", "converged", "dof_errors"} & found.keys()
    # to first order, of 0.5
    assert found["changes"]["stiffness"]["11"] == pytest.approx(0.4, abs=0.15)
    assert bool(found["remaining"]) == (method == "zhang_subspace")
    reply = service.request("POST", "/v1/updates", json=body | {"options": {"max_step": 0.1}})
    assert reply.status_code == 422
    assert reply.json()["context"]["field"] == "max_step"


def test_a_method_that_keeps_the_members_has_coefficients_of_each(service: Any, beam: str, full: str) -> None:
    found = run(service, beam, full, "eigendynamic_constraint")
    assert found["converged"]
    expected = [1.5 if n in (11, 12) else 1.0 for n in range(1, 21)]
    # exact shapes: only rounding is left
    np.testing.assert_allclose(
        [found["coefficients"]["stiffness"][str(n)] for n in range(1, 21)], expected, rtol=1e-6
    )
    np.testing.assert_allclose(list(found["coefficients"]["mass"].values()), 1.0, rtol=1e-6)
    assert found["connectivity_loss"] == {"mass": 0.0, "stiffness": 0.0}


def test_direct_methods_are_in_the_catalogue(service: Any) -> None:
    found = service.get("/v1/catalog/updating-methods")
    kinds = {one["kind"]: one["summary"] for one in found}
    options = {one["kind"]: set(one["parameters"]) for one in found}
    assert options["baruch"] == {"completion", "expansion", "n_modes"}
    assert options["zhang_subspace"] == {"suspect_threshold", "rank_jump", "min_mac"}
    for method in (
        *("baruch", "berman_nagy", "eigendynamic_constraint", "error_matrix", "modified_error_matrix"),
        *("zhang_sensitivity", "zhang_subspace"),
    ):
        assert kinds[method]
