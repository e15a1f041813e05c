"""Modes dropped or merged over HTTP."""

import io
from typing import Any

import numpy as np
import pytest


@pytest.fixture(scope="module")
def measured(service: Any, beam: str, rig: str) -> str:
    body = {"structure_id": beam, "rig_id": rig, "route": "drawn"}
    return str(service.result_of("/v1/measurements", body))


@pytest.fixture(scope="module", params=["lscf", "dobson"])
def modes(request: pytest.FixtureRequest, service: Any, measured: str) -> Any:
    body = {"measurement_id": measured, "method": request.param, "n_modes": 8}
    return service.get(f"/v1/modal-models/{service.result_of('/v1/modal-models', body)}")


def arrays(service: Any, id: str) -> Any:
    return np.load(io.BytesIO(service.request("GET", f"/v1/modal-models/{id}/arrays").content))


def test_a_selection_is_a_new_modal_model_of_the_same_measurement(
    service: Any, modes: Any, measured: str
) -> None:
    path = f"/v1/modal-models/{modes['id']}"
    known = [mode["frequency"] for mode in modes["modes"]]
    left = service.post(f"{path}/select", {"drop": [2], "merge": [[3, 4]]})
    assert left["id"] != modes["id"]
    assert left["measurement_id"] == measured
    frequencies = [mode["frequency"] for mode in left["modes"]]
    assert [frequencies[0], *frequencies[2:]] == [known[0], *known[4:]]
    assert known[2] <= frequencies[1] <= known[3]
    assert left["modes"][1]["flag_counts"]["merged"] == 1
    assert left["choices"]["selection"] == "dropped 2; merged 3 and 4: by request"
    assert known[1] in [pole["frequency"] for pole in left["doubtful"]]
    assert arrays(service, left["id"])["shapes"].shape[1] == len(frequencies)
    assert max(left["resynthesis_error"].values()) > max(modes["resynthesis_error"].values())
    assert service.get(path)["modes"] == modes["modes"]  # nothing is changed in place
    assert service.get(f"/v1/modal-models/{left['id']}") == left


def test_what_is_made_of_modes_is_made_of_a_selection(service: Any, modes: Any, beam: str) -> None:
    left = service.post(f"/v1/modal-models/{modes['id']}/select", {"drop": [8]})["id"]
    assert service.request("GET", f"/v1/modal-models/{left}/frf").status_code == 200
    found = service.post("/v1/correlations", {"modal_model_id": left, "structure_id": beam})
    assert len(found["pairs"]) == 7
    if modes["method"] == "lscf":
        chart = service.get(f"/v1/modal-models/{left}/chart")
        assert max(number for number in chart["mode"] if number is not None) == len(chart["modes"]) == 7
    else:
        query = {"mode": 7, "response": modes["dofs"][0]}
        fit = service.get(f"/v1/modal-models/{left}/fits", params=query)
        assert fit["frequency"] == pytest.approx(modes["modes"][6]["frequency"], rel=1e-3)
    again = service.post(f"/v1/modal-models/{left}/select", {"drop": [1]})
    assert len(again["modes"]) == 6
    assert again["choices"]["selection"] == "dropped 8, then dropped 1: by request"


def test_imported_modes_are_merged_by_their_shapes(service: Any) -> None:
    modes = [
        {"frequency": f, "shape": shape} for f, shape in ((20.0, [1, 2]), (21.0, [-1, -2]), (30.0, [2, 1]))
    ]
    known = service.post("/v1/modal-models/import", {"modes": modes, "dofs": ["1:+Y", "2:+Y"]})["id"]
    left = service.post(f"/v1/modal-models/{known}/select", {"merge": [[1, 2]]})
    assert [mode["frequency"] for mode in left["modes"]] == [20.5, 30.0]
    np.testing.assert_allclose(arrays(service, left["id"])["shapes"].real, [[1, 2], [2, 1]])


@pytest.mark.parametrize(
    ("body", "field", "value"),
    [
        ({}, "drop", []),
        ({"drop": [99]}, "drop", 99),
        ({"drop": [0]}, "drop", 0),
        ({"merge": [[1, 99]]}, "merge", 99),
        ({"merge": [[1]]}, "merge", [1]),
        ({"drop": [1], "merge": [[1, 2]]}, "merge", 1),
    ],
)
def test_unknown_numbers_are_refused_by_name(
    service: Any, modes: Any, body: Any, field: str, value: Any
) -> None:
    problem = service.post(f"/v1/modal-models/{modes['id']}/select", body, status=422)
    assert (problem["context"]["field"], problem["context"]["value"]) == (field, value)
    assert problem["context"]["allowed"]


@pytest.mark.parametrize("body", [{"keep": [1]}, {"drop": [1.5]}, {"drop": "1"}, {"merge": [1, 2]}])
def test_other_bodies_are_refused(service: Any, modes: Any, body: Any) -> None:
    service.post(f"/v1/modal-models/{modes['id']}/select", body, status=422)


def test_modes_of_no_model_are_not_found(service: Any) -> None:
    service.post("/v1/modal-models/none/select", {"drop": [1]}, status=404)
