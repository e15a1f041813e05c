"""Macro elements by a rule, over HTTP."""

from typing import Any

import pytest


@pytest.fixture(scope="module")
def modes(service: Any, beam: str) -> str:
    changes = [{"members": [7, 8], "property": "modulus", "factor": 1.3}]
    truth = service.post(f"/v1/structures/{beam}/changes", {"changes": changes})["id"]
    body = {"count": 6, "dofs": [f"{n}:+Y" for n in range(1, 22, 2)]}
    return str(service.post(f"/v1/structures/{truth}/synthetic-modes", body)["id"])


def asked(structure: str, modes: str, macros: Any) -> dict[str, Any]:
    shares = {"macros": macros, "parts": ["stiffness"]}
    return {
        "structure_id": structure,
        "modal_model_id": modes,
        "method": "one_shot",
        "parameterisation": shares,
    }


def located(service: Any, beam: str, modes: str, macros: Any) -> list[list[int]]:
    update = service.get(f"/v1/updates/{service.result_of('/v1/updates', asked(beam, modes, macros))}")
    return [macro["members"] for macro in update["history"][0]["macros"]]


def test_a_structure_is_divided_into_so_many_connected_parts(service: Any, beam: str, modes: str) -> None:
    parts = located(service, beam, modes, {"by": "partition", "count": 10})
    assert parts == [[i, i + 1] for i in range(1, 21, 2)]


def test_without_a_count_parts_have_about_four_members(service: Any, beam: str, modes: str) -> None:
    parts = located(service, beam, modes, {"by": "partition"})
    assert parts == [list(range(i, i + 4)) for i in range(1, 21, 4)]


def test_members_alike_are_one_macro_element(service: Any, beam: str, modes: str) -> None:
    assert located(service, beam, modes, {"by": "groups"}) == [list(range(1, 21))]


def test_one_macro_element_for_all_members_is_one_unknown_in_both_stages(
    service: Any, beam: str, modes: str
) -> None:
    body = asked(beam, modes, [list(range(1, 21))]) | {"method": "inverse_eigensensitivity"}
    update = service.get(f"/v1/updates/{service.result_of('/v1/updates', body)}")
    assert update["iterations"]["updating"] > 0
    assert {len(step["coefficients"]) for step in update["history"]} == {1}
    assert len(set(update["coefficients"]["stiffness"].values())) == 1


def test_an_update_that_corrects_nothing_says_so_first(service: Any, beam: str) -> None:
    exact = {"count": 6, "dofs": [f"{n}:+Y" for n in range(1, 22, 2)]}
    known = service.post(f"/v1/structures/{beam}/synthetic-modes", exact)["id"]
    body = asked(beam, known, "auto") | {"method": "inverse_eigensensitivity"}
    update = service.get(f"/v1/updates/{service.result_of('/v1/updates', body)}")
    assert set(update["coefficients"]["stiffness"].values()) == {1.0}
    assert update["stopped_because"].startswith("nothing is corrected")


@pytest.mark.parametrize(
    ("macros", "said"),
    [
        ({"by": "partition", "count": 21}, "20 members make no 21"),
        ({"by": "partition", "count": 0}, "greater than or equal to 1"),
        ({"by": "groups", "count": 3}, "there is no such field"),
        ({"by": "colour"}, "partition"),
    ],
)
def test_a_rule_that_means_nothing_is_refused(
    service: Any, beam: str, modes: str, macros: Any, said: str
) -> None:
    problem = service.post("/v1/updates", asked(beam, modes, macros), status=422)
    assert said in str(problem)
    assert "macros" in str(problem["context"])
