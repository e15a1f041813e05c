"""Correlation in full, reduced models and expanded modes over HTTP."""

import io
from typing import Any

import numpy as np
import pytest

from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.synthetic_modes import exact_modes

SENSORS = [f"{n}:{'+' if n % 4 == 1 else '-'}Y" for n in range(1, 22, 2)]
BEAM = STRUCTURES["chapter-5-beam"]()


def npz(service: Any, path: str, **params: Any) -> dict[str, Any]:
    reply = service.request("GET", path, params=params)
    assert reply.status_code == 200, reply.text
    return dict(np.load(io.BytesIO(reply.content)))


def refused(service: Any, path: str, body: Any) -> dict[str, Any]:
    reply = service.request("POST", path, json=body)
    assert reply.status_code == 422, reply.text
    return dict(reply.json())


@pytest.fixture(scope="module")
def modes(service: Any, beam: str) -> str:
    """Six modes of the beam at eleven points, exact."""
    body = {"count": 6, "dofs": SENSORS}
    return str(service.post(f"/v1/structures/{beam}/synthetic-modes", body)["id"])


@pytest.fixture(scope="module")
def stiffer(service: Any, beam: str) -> str:
    """The beam, 21 % stiffer throughout."""
    change = {"members": list(range(1, 21)), "property": "modulus", "factor": 1.21}
    return str(service.post(f"/v1/structures/{beam}/changes", {"changes": [change]})["id"])


@pytest.fixture(scope="module")
def measured(service: Any, stiffer: str) -> str:
    """FRFs of the stiffer beam, exact."""
    rig = service.post("/v1/rigs", {"drive": "1:+Y", "responses": SENSORS})["id"]
    body = {"structure_id": stiffer, "rig_id": rig, "route": "expected"}
    return str(service.result_of("/v1/measurements", body))


def test_a_correlation_says_by_itself_what_needs_no_mass(service: Any, beam: str, modes: str) -> None:
    found = service.post("/v1/correlations", {"modal_model_id": modes, "structure_id": beam})
    np.testing.assert_allclose(np.diag(found["mac"]), 1.0, rtol=1e-9)
    np.testing.assert_allclose(np.diag(found["pole_weighted_mac"]), 1.0, rtol=1e-9)
    np.testing.assert_allclose(found["ecomac"], 0.0, atol=1e-9)
    assert len(found["ecomac"]) == len(found["dofs"]) == 11
    assert found["orthogonality"] is None
    assert found["responses"] is None


@pytest.mark.parametrize(("kind", "most"), [("serep", 1e-9), ("irs", 2e-3), ("guyan", 0.05)])
def test_mass_tells_modes_apart_as_well_as_its_reduction_is(
    service: Any, beam: str, modes: str, kind: str, most: float
) -> None:
    body = {"modal_model_id": modes, "structure_id": beam, "reduction": kind}
    found = service.post("/v1/correlations", body)
    orthogonality = found["orthogonality"]
    assert orthogonality["reduction"] == kind
    assert max(orthogonality["frequency_errors"]) < most
    for name in ("cross", "auto"):
        # Guyan misses the sixth frequency by 2.6 %, IRS by 0.014 %: their masses are as far off
        np.testing.assert_allclose(orthogonality[name], np.eye(6), atol=most)
    assert service.get(f"/v1/correlations/{found['id']}") == found


def test_measured_frfs_show_a_global_stiffness(service: Any, beam: str, modes: str, measured: str) -> None:
    body: dict[str, Any] = {"modal_model_id": modes, "structure_id": beam, "measurement_id": measured}
    body |= {"reduction": {"kind": "serep", "parameters": {"modes": 7}}}
    found = service.post("/v1/correlations", body)
    assert found["made_from"]["measurement_id"] == measured
    orthogonality, responses = found["orthogonality"], found["responses"]
    assert orthogonality["parameters"] == {"modes": 7.0}
    assert orthogonality["n_motions"] == 2 + 7  # rigid-body motions of the free beam
    assert responses["frequency_scale"] == pytest.approx(1.1, rel=1e-3)  # sqrt(1.21); a sixth of a line
    assert responses["fdac_on_ridge"] > responses["fdac_unscaled"]
    shape = (len(responses["outputs"]), len(responses["inputs"]))
    assert np.array(responses["frac"]).shape == shape == (11, 1)
    assert responses["outputs"] == SENSORS
    arrays = npz(service, f"/v1/correlations/{found['id']}/arrays")
    for name in ("mac", "pole_weighted_mac", "pairs", "ecomac"):
        np.testing.assert_array_equal(arrays[name], found[name])
    np.testing.assert_array_equal(arrays["cross_orthogonality"], orthogonality["cross"])
    np.testing.assert_array_equal(arrays["frac"], responses["frac"])
    n = len(arrays["fdac_freq"])
    assert arrays["fdac"].shape == (1, n, n)
    assert n <= 200
    assert service.get(f"/v1/correlations/{found['id']}") == found
    half = npz(service, f"/v1/correlations/{found['id']}/arrays", precision="single")
    assert half["fdac"].dtype == np.float32


def test_without_frfs_the_arrays_hold_no_fdac(service: Any, beam: str, modes: str) -> None:
    found = service.post("/v1/correlations", {"modal_model_id": modes, "structure_id": beam})
    arrays = npz(service, f"/v1/correlations/{found['id']}/arrays")
    assert set(arrays) == {
        "mac",
        "pairs",
        "frequency_differences",
        "comac",
        "dofs",
        "ecomac",
        "pole_weighted_mac",
    }


def test_measured_modes_are_carried_to_all_dofs(service: Any, beam: str, modes: str) -> None:
    found = service.post(f"/v1/structures/{beam}/expanded-modes", {"modal_model_id": modes})
    assert found["made_from"] == {"structure_id": beam, "modal_model_id": modes}
    exact = exact_modes(assemble(BEAM), 6)
    arrays = npz(service, f"/v1/modal-models/{found['id']}/arrays")
    assert arrays["dofs"].tolist() == found["dofs"] == [str(dof) for dof in exact.dofs]
    np.testing.assert_allclose(arrays["shapes"], exact.shapes, atol=1e-6 * np.abs(exact.shapes).max())
    assert max(found["fit_residuals"]) < 1e-9
    np.testing.assert_allclose(found["rayleigh_frequencies"], exact.frequencies, rtol=1e-6)
    again = service.post("/v1/correlations", {"modal_model_id": found["id"], "structure_id": beam})
    assert len(again["dofs"]) == len(exact.dofs)


def test_what_the_model_would_not_do_is_flagged(service: Any, beam: str) -> None:
    shapes = np.zeros((11, 2))
    shapes[5, 0] = 1.0  # one point alone moves: no mode of a beam
    shapes[:, 1] = np.linspace(-1, 1, 11) ** 2 - 0.4  # much like the first mode
    dofs = [f"{n}:+Y" for n in range(1, 22, 2)]
    given = [{"frequency": f, "shape": list(s)} for f, s in zip((60.0, 23.6), shapes.T, strict=True)]
    known = service.post("/v1/modal-models/import", {"modes": given, "dofs": dofs})["id"]
    body = {"modal_model_id": known, "reduction": {"kind": "serep", "parameters": {"modes": 4}}}
    found = service.post(f"/v1/structures/{beam}/expanded-modes", body)
    assert [mode["flags"] for mode in found["modes"]] == [[], ["doubtful_expansion"]]
    assert found["fit_residuals"][1] > 0.5


def test_a_structure_is_reduced_to_the_dofs_asked_for(service: Any, beam: str) -> None:
    masters = [f"{n}:+Y" for n in range(1, 22, 2)]
    for kind, given in (("guyan", {}), ("irs", {"iterations": 3}), ("serep", {"modes": 6}), ("dynamic", {})):
        found = npz(service, f"/v1/structures/{beam}/reduced", masters=masters, kind=kind, **given)
        t = found["transformation"]
        assert found["masters"].tolist() == masters
        assert t.shape == (42, 11)
        system = assemble(BEAM)
        np.testing.assert_allclose(found["mass"], t.T @ (system.mass @ t), atol=1e-9)  # rounding, of kg
        assert len(found["frequency_errors"]) == len(found["model_frequencies"])
        assert (np.abs(found["frequency_errors"][:4]) < 0.01).all()


def test_the_catalogue_lists_reductions_with_their_numbers(service: Any) -> None:
    found = {one["kind"]: one for one in service.get("/v1/catalog/reductions")}
    assert set(found) >= {"guyan", "dynamic", "irs", "serep"}
    assert found["dynamic"]["parameters"]["frequency"]["unit"] == "Hz"
    assert all(one["summary"] for one in found.values())


def test_what_cannot_be_done_is_named(service: Any, beam: str, modes: str) -> None:
    ids = {"modal_model_id": modes, "structure_id": beam}
    cases: list[tuple[Any, str]] = [
        ("magic", "reduction"),
        ({"kind": "guyan", "parameters": {"modes": 3}}, "reduction"),
        ({"kind": "serep", "parameters": {"modes": 10}}, "modes"),
        ({"kind": "serep", "parameters": {"modes": 2.5}}, "modes"),
        ({"kind": "dynamic", "parameters": {"frequency": -1}}, "frequency"),
    ]
    for reduction, field in cases:
        for path, body in (
            ("/v1/correlations", ids | {"reduction": reduction}),
            (f"/v1/structures/{beam}/expanded-modes", {"modal_model_id": modes, "reduction": reduction}),
        ):
            problem = refused(service, path, body)
            assert problem["context"]["field"] == field, problem
            assert problem["context"]["allowed"]


def test_a_structure_that_sensors_leave_free_is_refused_a_static_reduction(service: Any) -> None:
    bay = service.post("/v1/structures", {"kind": "catalogue", "name": "bay"})["id"]
    across = [f"{n}:+Y" for n in range(1, 31)]
    modes = service.post(f"/v1/structures/{bay}/synthetic-modes", {"count": 4, "dofs": across})["id"]
    ids = {"modal_model_id": modes, "structure_id": bay}
    problem = refused(service, "/v1/correlations", ids | {"reduction": "guyan"})
    assert "1 of 3 rigid-body motions" in problem["detail"]
    assert problem["context"]["field"] == "reduction"
    # the mass of the modes themselves does it
    found = service.post(
        "/v1/correlations", ids | {"reduction": {"kind": "serep", "parameters": {"modes": 4}}}
    )
    np.testing.assert_allclose(found["orthogonality"]["cross"], np.eye(4), atol=1e-9)


def test_what_is_too_much_to_wait_for_is_refused(service: Any) -> None:
    large = {"kind": "beam", "length": 1.5, "n_elements": 1000}
    large |= {"section": {"area": 5e-4, "second_moment": 4e-9}}
    large |= {"material": {"modulus": 2e11, "density": 7800.0}}
    structure = service.post("/v1/structures", large)["id"]
    dofs = [f"{node}:+Y" for node in range(1, 1002)]
    given = [{"frequency": 20.0, "shape": [1.0] * len(dofs)}]
    known = service.post("/v1/modal-models/import", {"modes": given, "dofs": dofs})["id"]
    ids = {"modal_model_id": known, "structure_id": structure}
    for path, body, field in (
        ("/v1/correlations", {**ids, "reduction": "guyan"}, "reduction"),
        (f"/v1/structures/{structure}/expanded-modes", {"modal_model_id": known}, "modal_model_id"),
    ):
        context = refused(service, path, body)["context"]
        assert (context["field"], context["value"]) == (field, 2002 * 1001)


def test_dofs_in_common_with_nothing_are_named(service: Any, beam: str, measured: str) -> None:
    given = [{"frequency": 20.0, "shape": [1.0, 2.0]}]
    stray = service.post("/v1/modal-models/import", {"modes": given, "dofs": ["98:+Y", "99:+Y"]})["id"]
    ids = {"modal_model_id": stray, "structure_id": beam}
    for body in (ids, ids | {"reduction": "guyan"}):
        assert refused(service, "/v1/correlations", body)["context"]["field"] == "dofs"
    path = f"/v1/structures/{beam}/expanded-modes"
    assert refused(service, path, {"modal_model_id": stray})["context"]["field"] == "dofs"
    two = service.post(
        "/v1/structures",
        {
            "kind": "beam",
            "length": 1.0,
            "n_elements": 2,
            "section": {"area": 1e-4, "second_moment": 1e-9},
            "material": {"modulus": 2e11, "density": 7800.0},
        },
    )["id"]
    few = service.post(f"/v1/structures/{two}/synthetic-modes", {"count": 1, "dofs": ["2:+Y"]})["id"]
    reply = service.request("GET", f"/v1/structures/{two}/reduced", params={"masters": ["2:+Y"]})
    assert reply.status_code == 422
    assert reply.json()["context"]["field"] == "reduction"
    body = {"modal_model_id": few, "structure_id": two, "measurement_id": measured}
    found = service.post("/v1/correlations", body)  # points 1 and 3 are there too
    assert found["responses"]["outputs"] == ["1:+Y", "3:-Y"]
    assert found["responses"]["notes"] == ["9 measured points are none of the model's"]
