"""Structures over HTTP: the bodies of the contract, their modes, their changes."""

import io
from typing import Any

import numpy as np
import pytest

SECTION = {"area": 5e-4, "second_moment": 4.1667e-9}
STEEL = {"modulus": 2.09e11, "density": 7800.0}
PARTS = {"section": SECTION, "material": STEEL}
BEAM = {
    "kind": "beam",
    "length": 1.5,
    "n_elements": 20,
    "section": SECTION,
    "material": STEEL,
    "damping": {"law": "structural", "stiffness_coefficient": 0.005, "mass_coefficient": 100.0},
    "theory": "bernoulli_euler",
    "supports": [],
}
FRAME = {
    "kind": "frame",
    "nodes": {"1": [0.0, 0.0], "2": [1.0, 0.0], "3": [1.0, 1.0]},
    "sections": {"bar": SECTION},
    "materials": {"steel": STEEL},
    "members": [
        {"number": 1, "nodes": [1, 2], "section": "bar", "material": "steel"},
        {"number": 2, "nodes": [2, 3], "section": "bar", "material": "steel"},
    ],
    "supports": [{"node": 1, "directions": ["X", "Y", "RZ"]}],
}


def modes_of(service: Any, structure: str, count: int = 8) -> Any:
    return service.get(f"/v1/structures/{structure}/modes", params={"count": count})


def test_a_described_beam_is_the_catalogues(service: Any, beam: str) -> None:
    described = service.post("/v1/structures", BEAM)
    assert (described["n_nodes"], described["n_dofs"], described["members"]) == (21, 42, 20)
    found, expected = modes_of(service, described["id"]), modes_of(service, beam)
    # two assemblies of the same numbers: the same to the last bit
    assert found["frequencies"] == expected["frequencies"]
    assert found["n_rigid_body"] == 2


def test_modes_have_the_loss_factors_of_their_damping_law(service: Any, beam: str) -> None:
    modes = modes_of(service, beam)
    squares = (2 * np.pi * np.array(modes["frequencies"])) ** 2
    # eta_r = a / lambda_r + b holds exactly; what is left is rounding of the eigen-solution
    np.testing.assert_allclose(modes["loss_factors"], 100.0 / squares + 0.005, rtol=1e-6)


def test_a_frame_is_held_where_its_supports_say(service: Any) -> None:
    frame = service.post("/v1/structures", FRAME)
    assert (frame["n_nodes"], frame["n_dofs"]) == (3, 6)
    assert modes_of(service, frame["id"])["n_rigid_body"] == 0


@pytest.mark.parametrize(
    "damping",
    [
        {"law": "modal", "loss_factors": 0.02},
        {"law": "modal", "damping_ratios": [0.01, 0.01, 0.01, 0.01]},
    ],
)
def test_a_damping_ratio_is_half_a_loss_factor(service: Any, damping: Any) -> None:
    structure = service.post("/v1/structures", BEAM | {"damping": damping})["id"]
    np.testing.assert_allclose(modes_of(service, structure, 4)["loss_factors"], 0.02, rtol=1e-6)


def test_a_viscous_law_gives_loss_factors_that_rise_with_frequency(service: Any) -> None:
    law = {"law": "viscous", "stiffness_coefficient": 1e-5}
    structure = service.post("/v1/structures", BEAM | {"damping": law})["id"]
    modes = modes_of(service, structure, 4)
    # 2 zeta_r = b omega_r of C = b K
    omega = 2 * np.pi * np.array(modes["frequencies"])
    np.testing.assert_allclose(modes["loss_factors"], 1e-5 * omega, rtol=1e-6)


@pytest.mark.parametrize("body", [BEAM, FRAME])
def test_a_structure_that_shears_has_lower_frequencies(service: Any, body: Any) -> None:
    plain, sheared, softer = (
        modes_of(service, service.post("/v1/structures", made)["id"], 3)["frequencies"]
        for made in (
            body,
            body | {"theory": "timoshenko"},
            with_shear(body, shear_coefficient=0.3, poisson_ratio=0.45),
        )
    )
    assert (np.array(sheared) < plain).all()
    assert (np.array(softer) < sheared).all()


def with_shear(body: Any, *, shear_coefficient: float, poisson_ratio: float) -> Any:
    section = SECTION | {"shear_coefficient": shear_coefficient}
    steel = STEEL | {"poisson_ratio": poisson_ratio}
    parts = {
        "section": section,
        "material": steel,
        "sections": {"bar": section},
        "materials": {"steel": steel},
    }
    return body | {name: part for name, part in parts.items() if name in body} | {"theory": "timoshenko"}


@pytest.mark.parametrize(
    ("part", "name", "value"),
    [("section", "shear_coefficient", 0.0), ("material", "poisson_ratio", 0.6)],
)
def test_a_section_or_material_that_cannot_be_is_refused_by_name(
    service: Any, part: str, name: str, value: float
) -> None:
    reply = service.request("POST", "/v1/structures", json=BEAM | {part: PARTS[part] | {name: value}})
    assert (reply.status_code, reply.json()["context"]["field"]) == (422, name)


def test_a_change_makes_a_new_structure_and_leaves_the_old(service: Any, beam: str) -> None:
    before = modes_of(service, beam)["frequencies"]
    changes = [
        {"members": [1, 2], "property": "density", "factor": 2.0},
        {"members": [11, 12], "property": "modulus", "factor": 2.0},
        {"members": [1], "property": "loss_factor", "value": 0.05},
        {"node": 7, "property": "mass", "value": 0.05},
        {"dof": "1:+Y", "property": "ground_stiffness", "value": 1e4},
    ]
    changed = service.post(f"/v1/structures/{beam}/changes", {"changes": changes})
    assert changed["made_from"] == {"structure_id": beam}
    assert modes_of(service, beam)["frequencies"] == before
    assert modes_of(service, changed["id"])["n_rigid_body"] == 1
    assert service.request("DELETE", f"/v1/structures/{beam}").status_code == 409


def test_doubling_every_density_lowers_every_frequency_by_the_root_of_two(service: Any, beam: str) -> None:
    changes = [{"members": list(range(1, 21)), "property": "density", "factor": 2.0}]
    changed = service.post(f"/v1/structures/{beam}/changes", {"changes": changes})["id"]
    found = np.array(modes_of(service, changed)["frequencies"])
    # exact but for rounding of the eigen-solution
    np.testing.assert_allclose(found * np.sqrt(2), modes_of(service, beam)["frequencies"], rtol=1e-7)


def test_shapes_come_as_arrays_with_their_dofs(service: Any, beam: str) -> None:
    reply = service.request("GET", f"/v1/structures/{beam}/modes/arrays", params={"count": 5})
    arrays = np.load(io.BytesIO(reply.content))
    assert reply.headers["vary"] == "Accept"
    assert arrays["shapes"].shape == (42, 5)
    assert arrays["dofs"][:2].tolist() == ["1:+Y", "1:+RZ"]


def test_a_large_structure_gives_as_many_modes_as_asked_for(service: Any) -> None:
    fine = service.post("/v1/structures", BEAM | {"n_elements": 200})["id"]
    coarse = service.post("/v1/structures", BEAM | {"n_elements": 60})["id"]
    found, expected = (modes_of(service, structure, 12)["frequencies"] for structure in (fine, coarse))
    assert len(found) == 12
    # cubic elements err by (beta h)^4/1440 in frequency: 1.3e-4 at mode 12 of 60 elements
    np.testing.assert_allclose(found, expected, rtol=2e-4)


def test_a_removed_structure_is_gone(service: Any) -> None:
    structure = service.post("/v1/structures", BEAM)["id"]
    assert service.request("DELETE", f"/v1/structures/{structure}").status_code == 204
    assert service.request("GET", f"/v1/structures/{structure}").status_code == 404


def test_lists_go_on_page_by_page(service: Any) -> None:
    ids = [service.post("/v1/structures", BEAM)["id"] for _ in range(3)]
    first = service.get("/v1/structures", params={"limit": 2})
    second = service.get("/v1/structures", params={"limit": 2, "after": first["next"]})
    seen = [item["id"] for item in first["items"] + second["items"]]
    assert seen[:3] == ids[::-1]


def test_synthetic_modes_scatter_as_told_and_come_again_from_their_seed(service: Any, beam: str) -> None:
    body = {
        "count": 6,
        "dofs": ["1:+Y", "9:-Y"],
        "noise": {"eigenvalue": 0.01, "eigenvector": 0.05},
        "seed": 3,
    }
    first = service.post(f"/v1/structures/{beam}/synthetic-modes", body)
    again = service.post(f"/v1/structures/{beam}/synthetic-modes", body)
    other = service.post(f"/v1/structures/{beam}/synthetic-modes", body | {"seed": 4})
    exact = np.array(modes_of(service, beam, 6)["frequencies"])
    frequencies = [np.array([mode["frequency"] for mode in made["modes"]]) for made in (first, again, other)]
    assert np.array_equal(frequencies[0], frequencies[1])
    assert not np.array_equal(frequencies[0], frequencies[2])
    # uniform noise of 1 % on the eigenvalue is at most half of that on the frequency
    assert (np.abs(frequencies[0] / exact - 1) < 0.0051).all()
    assert (first["seed"], first["made_from"]) == (3, {"structure_id": beam})


def test_the_geometry_names_nodes_members_and_free_dofs(service: Any) -> None:
    cantilever = service.post("/v1/structures", {"kind": "catalogue", "name": "cantilever"})["id"]
    geometry = service.get(f"/v1/structures/{cantilever}/geometry")
    assert geometry["nodes"]["21"] == [1.5, 0.0]
    assert geometry["members"][6] == {"number": 7, "nodes": [7, 8]}
    assert geometry["dofs"][:2] == ["2:+Y", "2:+RZ"]  # node 1 is clamped
