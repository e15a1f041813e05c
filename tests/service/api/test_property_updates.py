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
    assert study["table"][0]["coefficient_error"][0] < 1e-6
    assert study["table"][0]["suspected"] == 1.0


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
    assert (problem["context"]["field"], problem["context"]["allowed"]) == ("property", "thickness")
