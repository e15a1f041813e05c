"""Properties of members as coefficients of an update, over HTTP."""

from typing import Any

import pytest

LOWER, UPPER = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12], [13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24]
SENSORS = [f"{node}:+Z" for node in range(1, 36, 2)]


@pytest.fixture(scope="module")
def plate(service: Any) -> str:
    body = {
        "kind": "plate",
        "length": 0.6,
        "width": 0.4,
        "thickness": 0.004,
        "n_elements": [6, 4],
        "material": {"modulus": 2.09e11, "density": 7800.0},
    }
    return str(service.post("/v1/structures", body)["id"])


@pytest.fixture(scope="module")
def modes(service: Any, plate: str) -> str:
    """Modes of the plate with a thicker half."""
    changes = [{"members": UPPER, "property": "thickness", "value": 0.005}]
    thicker = service.post(f"/v1/structures/{plate}/changes", {"changes": changes})["id"]
    body = {"count": 6, "dofs": SENSORS}
    return str(service.post(f"/v1/structures/{thicker}/synthetic-modes", body)["id"])


def asked(structure: str, modes: str, *parts: str, method: str = "one_shot") -> dict[str, Any]:
    shares = {"macros": [LOWER, UPPER], "parts": list(parts)}
    return {
        "structure_id": structure,
        "modal_model_id": modes,
        "method": method,
        "parameterisation": shares,
    }


def test_a_thickness_comes_back_in_metres(service: Any, plate: str, modes: str) -> None:
    id = service.result_of("/v1/updates", asked(plate, modes, "thickness"))
    update = service.get(f"/v1/updates/{id}")
    assert update["suspected"] == {"thickness": UPPER}
    assert update["coefficients"]["thickness"]["13"] == pytest.approx(1.25, abs=1e-6)
    right, wrong = update["quantities"]
    assert (wrong["part"], wrong["members"], wrong["unit"]) == ("thickness", UPPER, "m")
    assert (wrong["before"], right["after"]) == (0.004, pytest.approx(0.004, rel=1e-6))
    assert wrong["after"] == pytest.approx(0.005, rel=1e-6)
    low, high = wrong["interval"]
    assert low <= wrong["after"] <= high
    measured = service.get(f"/v1/structures/{update['structure_id']}/modes", params={"count": 6})
    assert measured["frequencies"] == pytest.approx(update["frequencies"]["measured"], rel=1e-6)


def test_a_study_tries_a_method_on_a_thickness(service: Any, plate: str) -> None:
    changes = [{"members": UPPER, "property": "thickness", "factor": 1.2}]
    truth = service.post(f"/v1/structures/{plate}/changes", {"changes": changes})["id"]
    body = {
        "structure_id": plate,
        "truth_id": truth,
        "levels": ["NL1"],
        "divisions": {"halves": [LOWER, UPPER]},
        "seeds": [1],
        "count": 6,
        "dofs": SENSORS,
        "parts": ["thickness", "density"],
    }
    study = service.get(f"/v1/studies/{service.result_of('/v1/studies', body)}")
    assert study["wrong"] == {"thickness": {str(n): pytest.approx(1.2) for n in UPPER}, "density": {}}
    assert study["cells"][0]["coefficient_error"][0] < 1e-6
    assert study["cells"][0]["suspected"] == 1.0


@pytest.mark.parametrize(
    ("parts", "field", "words"),
    [
        (("modulus", "stiffness"), "macros", "modulus and of stiffness, which both move its axial matrix"),
        (("mass", "thickness"), "macros", "mass and of thickness, which both move its mass matrix"),
        (("area",), "parts", "member 1 is a plate, which has no area"),
        (("weight",), "parts", "elements have no part 'weight'"),
    ],
)
def test_what_does_not_go_together_is_refused_in_words(
    service: Any, plate: str, modes: str, parts: tuple[str, ...], field: str, words: str
) -> None:
    problem = service.post("/v1/updates", asked(plate, modes, *parts), status=422)
    assert problem["context"]["field"] == field
    assert words in problem["detail"]
    assert problem["context"]["allowed"]


def test_a_plate_has_no_area_to_change(service: Any, plate: str) -> None:
    changes = [{"members": [1], "property": "area", "factor": 2.0}]
    problem = service.post(f"/v1/structures/{plate}/changes", {"changes": changes}, status=422)
    assert (problem["context"]["field"], problem["context"]["allowed"]) == ("property", ["thickness"])


MOUNTED = {
    "kind": "beam",
    "length": 1.0,
    "n_elements": 10,
    "section": {"area": 1e-3, "second_moment": 8e-9},
    "material": {"modulus": 2.09e11, "density": 7800.0},
    "springs": [{"dof": "1:+Y", "stiffness": 2e5}, {"dof": "11:+Y", "stiffness": 2e5}],
}
POINTS = [f"{node}:+Y" for node in range(1, 12)]
TRUE_MASS, MASS = 0.3, 0.2


def mounted(service: Any, mass: float, spring: float) -> str:
    """A beam on two springs with a mass that is an effect of the model, not one of its point masses."""
    springs = [{"dof": "1:+Y", "stiffness": spring}, *MOUNTED["springs"][1:]]  # type: ignore[index]
    effects = [{"kind": "extra_mass", "at": "4:+Y", "parameters": {"mass": mass}}]
    body = MOUNTED | {"springs": springs, "effects": effects}
    return str(service.post("/v1/structures", body)["id"])


@pytest.fixture(scope="module")
def mounts(service: Any) -> tuple[str, str]:
    """The model, and modes of what it should be."""
    model, truth = mounted(service, MASS, 2e5), mounted(service, TRUE_MASS, 1e5)
    body = {"count": 5, "dofs": POINTS}
    return model, str(service.post(f"/v1/structures/{truth}/synthetic-modes", body)["id"])


def test_mounts_and_masses_are_found_at_their_nodes(service: Any, mounts: tuple[str, str]) -> None:
    model, modes = mounts
    attached = {"point_mass": "each", "ground_spring_y": [[1], [11]]}
    body = asked(model, modes) | {"parameterisation": {"parts": [], "attached": attached}}
    update = service.get(f"/v1/updates/{service.result_of('/v1/updates', body)}")
    assert update["suspected"] == {"point_mass": [4], "ground_spring_y": [1]}
    found = {(one["part"], *one["members"]): one for one in update["quantities"]}
    assert found["point_mass", 4]["after"] == pytest.approx(TRUE_MASS, rel=1e-6)
    assert (found["point_mass", 4]["before"], found["point_mass", 4]["unit"]) == (MASS, "kg")
    assert found["ground_spring_y", 1]["after"] == pytest.approx(1e5, rel=1e-6)
    assert found["ground_spring_y", 11]["after"] == pytest.approx(2e5, rel=1e-6)
    corrected = service.get(f"/v1/structures/{update['structure_id']}/modes", params={"count": 5})
    assert corrected["frequencies"] == pytest.approx(update["frequencies"]["measured"], rel=1e-6)


def test_an_effect_that_the_model_has_is_not_taken_for_an_error(service: Any) -> None:
    right = mounted(service, MASS, 2e5)
    body = {"count": 5, "dofs": POINTS}
    modes = service.post(f"/v1/structures/{right}/synthetic-modes", body)["id"]
    groups = {"macros": [[1, 2, 3, 4, 5], [6, 7, 8, 9, 10]]}
    body = asked(right, modes) | {"parameterisation": groups}
    update = service.get(f"/v1/updates/{service.result_of('/v1/updates', body)}")
    assert update["suspected"] == {"mass": [], "stiffness": []}
    assert update["frequencies"]["before"] == pytest.approx(update["frequencies"]["measured"], rel=1e-9)


@pytest.mark.parametrize(
    ("attached", "words"),
    [
        ({"point_mass": [[5]]}, "node 5 carries no point mass"),
        ({"ground_spring_rz": "each"}, "no node carries a ground spring RZ"),
        ({"joint": "each"}, "nodes carry no 'joint'"),
    ],
)
def test_what_nodes_do_not_carry_is_refused_in_words(
    service: Any, mounts: tuple[str, str], attached: dict[str, Any], words: str
) -> None:
    body = asked(*mounts) | {"parameterisation": {"parts": [], "attached": attached}}
    problem = service.post("/v1/updates", body, status=422)
    assert problem["context"]["field"] == "attached"
    assert words in problem["detail"]


def test_an_update_of_nothing_is_refused(service: Any, mounts: tuple[str, str]) -> None:
    body = asked(*mounts) | {"parameterisation": {"parts": []}}
    assert service.post("/v1/updates", body, status=422)["context"]["field"] == "macros"


def test_a_joint_is_found_at_its_node_whether_effect_or_change(service: Any) -> None:
    body = {
        "kind": "beam",
        "length": 1.5,
        "n_elements": 10,
        "section": {"area": 5e-4, "second_moment": 4.1667e-9},
        "material": {"modulus": 2.09e11, "density": 7800.0},
        "effects": [{"kind": "joint_flexibility", "at": "6:+RZ", "parameters": {"flexibility": 5e-5}}],
    }
    model = service.post("/v1/structures", body)["id"]
    plain = service.post("/v1/structures", body | {"effects": []})["id"]
    worn = {"changes": [{"node": 6, "property": "joint_stiffness", "value": 1e4}]}
    truth = service.post(f"/v1/structures/{plain}/changes", worn)["id"]
    modes = {"count": 6, "dofs": [f"{node}:+Y" for node in range(1, 12, 2)]}
    seen = service.post(f"/v1/structures/{truth}/synthetic-modes", modes)["id"]
    loose = {"parts": [], "attached": {"joint_stiffness": "each"}}
    id = service.result_of("/v1/updates", asked(model, seen) | {"parameterisation": loose})
    update = service.get(f"/v1/updates/{id}")
    (found,) = update["quantities"]
    assert (found["members"], found["unit"], found["before"]) == ([6], "N m/rad", pytest.approx(2e4))
    assert found["after"] == pytest.approx(1e4, rel=1e-6)
    measured = service.get(f"/v1/structures/{update['structure_id']}/modes", params={"count": 6})
    assert measured["frequencies"] == pytest.approx(update["frequencies"]["measured"], rel=1e-6)
