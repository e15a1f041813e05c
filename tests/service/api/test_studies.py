"""Studies over HTTP: asked for, refused, and what comes back."""

import io
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modallab.api.limits import REQUEST
from modallab.api.studies import schemas

SENSORS = [f"{n}:+Y" for n in range(1, 22, 2)]
LEVELS = ["NL1", {"name": "own", "eigenvalue": 0.002, "eigenvector": 0.02, "distribution": "normal"}]


@pytest.fixture(scope="module")
def stiffer(service: Any, beam: str) -> str:
    """The beam with two stiffer members."""
    changes = [{"members": [11, 12], "property": "modulus", "factor": 1.5}]
    return str(service.post(f"/v1/structures/{beam}/changes", {"changes": changes})["id"])


def asked(beam: str, truth: str, **more: Any) -> dict[str, Any]:
    body = {"structure_id": beam, "truth_id": truth, "levels": LEVELS, "seeds": [5, 6], "count": 8}
    return body | {"dofs": SENSORS, "divisions": {"each": "each", "two": [[11], [12]]}} | more


@pytest.fixture(scope="module")
def found(service: Any, beam: str, stiffer: str) -> Any:
    """A study of two levels, two divisions and two seeds."""
    return service.get(f"/v1/studies/{service.result_of('/v1/studies', asked(beam, stiffer))}")


def arrays(service: Any, id: str) -> dict[str, Any]:
    reply = service.request("GET", f"/v1/studies/{id}/arrays")
    assert reply.status_code == 200, reply.text
    with np.load(io.BytesIO(reply.content)) as file:
        return dict(file)


def test_a_table_has_a_row_for_every_level_and_division(found: Any) -> None:
    assert [(row["level"], row["division"]) for row in found["cells"]] == [
        ("NL1", "each"),
        ("NL1", "two"),
        ("own", "each"),
        ("own", "two"),
    ]
    assert [level["name"] for level in found["plan"]["levels"]] == ["NL1", "own"]
    assert found["plan"]["levels"][1]["noise"]["distribution"] == "normal"
    assert found["plan"]["options"]["max_iterations"] == 30
    division = found["plan"]["divisions"][1]
    assert division["parameterisation"]["macros"][0] == {"members": [11], "part": "mass"}
    assert found["true"]["stiffness"]["11"] == 1.5
    assert found["wrong"] == {"mass": {}, "stiffness": {"11": 1.5, "12": 1.5}}
    for row in found["cells"]:
        assert (row["n_runs"], row["n_failed"], row["suspected"]) == (2, 0, 1.0)
        median, most = row["coefficient_error"]
        assert median <= most
    # exact modes, quadratic convergence below 1e-4
    assert found["cells"][0]["coefficient_error"][1] < 1e-6
    assert found["cells"][2]["coefficient_error"][0] > 1e-6


def test_every_run_can_be_made_again_as_an_update(service: Any, beam: str, stiffer: str, found: Any) -> None:
    run, table = found["runs"][5], arrays(service, found["id"])
    assert (run["level"], run["division"], run["seed"]) == ("own", "each", 6)
    noise = {"eigenvalue": 0.002, "eigenvector": 0.02, "distribution": "normal"}
    body = {"count": 8, "dofs": SENSORS, "noise": noise, "seed": 6}
    modes = service.post(f"/v1/structures/{stiffer}/synthetic-modes", body)["id"]
    body = {"structure_id": beam, "modal_model_id": modes, "method": "one_shot"}
    id = service.result_of("/v1/updates", body | {"parameterisation": {"macros": "each"}})
    update = service.get(f"/v1/updates/{id}")
    assert update["suspected"] == run["suspected"]
    assert update["stopped_because"] == run["stopped_because"]
    alone = [value for part in ("mass", "stiffness") for value in update["coefficients"][part].values()]
    np.testing.assert_array_equal(table["coefficients"][5], alone)
    assert table["levels"][5] == "own"
    assert table["seeds"].tolist() == [5, 6] * 4
    assert table["members"].tolist() == [*range(1, 21)] * 2
    assert table["true"][30] == 1.5  # stiffness of 11


def test_the_same_seeds_give_the_same_bytes(service: Any, beam: str, stiffer: str, found: Any) -> None:
    again = service.result_of("/v1/studies", asked(beam, stiffer))
    one, other = (service.request("GET", f"/v1/studies/{id}/arrays").content for id in (found["id"], again))
    assert one == other
    assert service.get(f"/v1/studies/{again}")["cells"] == found["cells"]


def test_runs_that_cannot_be_made_are_rows_of_a_study_that_succeeds(
    service: Any, beam: str, stiffer: str
) -> None:
    id = service.result_of("/v1/studies", asked(beam, stiffer, count=2, levels=["NL1"]))
    study = service.get(f"/v1/studies/{id}")
    each, two = study["cells"]
    assert (each["n_failed"], each["coefficient_error"]) == (2, None)
    assert two["n_failed"] == 0
    assert study["runs"][0]["stopped_because"] == "24 measured numbers cannot determine 40 coefficients"
    assert study["runs"][0]["coefficient_error"] is None
    table = arrays(service, id)["coefficients"]
    assert np.isnan(table[:2]).all()
    assert np.isfinite(table[2:]).all()


def test_a_study_is_listed_and_holds_its_structures(service: Any, stiffer: str, found: Any) -> None:
    assert found["id"] in [one["id"] for one in service.get("/v1/studies")["items"]]
    reply = service.request("DELETE", f"/v1/structures/{stiffer}")
    assert (reply.status_code, reply.json()["code"]) == (409, "in_use")


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "a method on matrices": ({"method": "baruch"}, "method"),
    "a level that there is not": ({"levels": ["NL5"]}, "levels"),
    "noise beyond bounds": ({"levels": [{"name": "all", "eigenvalue": 1.5}]}, "eigenvalue"),
    "a level twice": ({"levels": ["NL1", "NL1"]}, "levels"),
    "no level": ({"levels": []}, "body.levels"),
    "a seed twice": ({"seeds": [1, 1]}, "seeds"),
    "too many runs": ({"seeds": list(range(600))}, "seeds"),
    "a member that there is not": ({"divisions": {"one": [[99]]}}, "members"),
    "no division": ({"divisions": {}}, "body.divisions"),
    "a part that there is not": ({"parts": ["torsion"]}, "parts"),
    "loss factors by real modes": ({"parts": ["damping"]}, "parts"),
    "a DoF that there is not": ({"dofs": ["99:+Y"]}, "dof"),
    "a DoF that is no DoF": ({"dofs": ["top"]}, "dofs"),
    "a DoF twice": ({"dofs": ["1:+Y", "5:+Y", "1:-Y"]}, "dofs"),
    "draws that a study would not keep": ({"method": "one_shot", "options": {"samples": 100}}, "samples"),
    "an option of another method": ({"options": {"max_step": 0.2}}, "max_step"),
    "a bound on the wrong side": ({"lower": 2.0}, "lower"),
    "an unknown field": ({"seed": 1}, "body.seed"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_studied_is_refused_by_field(service: Any, beam: str, stiffer: str, case: str) -> None:
    wrong, field = WRONG[case]
    refused = service.post("/v1/studies", asked(beam, stiffer, **wrong), status=422)
    assert refused["context"]["field"] == field


def test_a_truth_that_is_another_structure_is_refused(service: Any, beam: str) -> None:
    other = service.post("/v1/structures", {"kind": "catalogue", "name": "bay"})["id"]
    refused = service.post("/v1/studies", asked(beam, other), status=422)
    assert refused["context"] == {"field": "truth_id", "value": 31, "allowed": "a changed copy of the model"}


def test_more_coefficients_than_are_kept_are_refused_with_the_runs_that_fit(
    service: Any, beam: str, stiffer: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(schemas, "REQUEST", replace(REQUEST, study_coefficients=250))
    refused = service.post("/v1/studies", asked(beam, stiffer), status=422)
    assert refused["context"] == {"field": "seeds", "value": 8, "allowed": {"maximum": 6, "unit": "runs"}}
