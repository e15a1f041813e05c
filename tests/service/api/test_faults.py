"""A body that makes no sense is told so in its own words, not in those of what tried to read it."""

from typing import Any

import pytest

MACROS: dict[str, tuple[Any, str, str]] = {
    "no macro element": ([], "body.parameterisation.macros", "at least 1 item"),
    "one without members": ([[1], []], "body.parameterisation.macros.1", "at least 1 item"),
    "a member beyond 64 bits": ([[1, 10**30]], "body.parameterisation.macros.0.1", "less than or equal"),
    "too many parts": (
        {"by": "partition", "count": 10_000},
        "body.parameterisation.macros.partition.count",
        "less than or equal to 1000",
    ),
    "an unknown rule": ({"by": "magic"}, "body.parameterisation.macros", "'groups', 'partition'"),
    "an unknown word": ("all", "body.parameterisation.macros", "'auto' or 'each'"),
}


@pytest.mark.parametrize("case", MACROS)
def test_of_several_forms_the_one_that_was_meant_says_what_is_wrong(service: Any, case: str) -> None:
    macros, field, words = MACROS[case]
    body = {"structure_id": "any", "modal_model_id": "any", "parameterisation": {"macros": macros}}
    problem = service.post("/v1/updates", body, status=422)
    assert problem["context"]["field"] == field
    assert words in problem["detail"]
    assert problem["context"]["errors"][0]["field"] == field


def test_a_shape_entry_that_is_too_large_is_named_by_its_place(service: Any) -> None:
    body = {"modes": [{"frequency": 10.0, "shape": [1.0, 1e300]}], "dofs": ["1:+X", "2:+X"]}
    problem = service.post("/v1/modal-models/import", body, status=422)
    assert problem["context"]["field"] == "body.modes.0.shape.1"


def test_a_level_of_noise_that_is_wrong_inside_is_named_by_its_field(service: Any) -> None:
    level = {"name": "own", "eigenvalue": "small"}
    body = {"structure_id": "any", "truth_id": "any", "dofs": ["1:+Y"], "levels": ["NL1", level]}
    problem = service.post("/v1/studies", body, status=422)
    assert problem["context"]["field"] == "body.levels.1.eigenvalue"


def test_a_body_that_is_missing_or_no_object_is_named_as_a_whole(service: Any) -> None:
    for sent in ({}, {"json": [1, 2]}):
        reply = service.request("POST", "/v1/updates", **sent)
        assert (reply.status_code, reply.json()["context"]["field"]) == (422, "body")


def test_a_form_that_describes_a_mesh_wrongly_is_told_in_its_own_names(service: Any) -> None:
    files = {"file": ("a.msh", b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n")}
    data = {"mesh": '{"groups": {"skin": {"thickness": 0.01}}}'}
    reply = service.request("POST", "/v1/structures/import", files=files, data=data)
    assert (reply.status_code, reply.json()["context"]["field"]) == (422, "mesh.groups.skin.material")
