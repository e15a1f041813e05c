"""Problem documents: titles in words, values as JSON, names that are allowed and the nearest of them."""

from typing import Any

import pytest

from modallab.api.problems import CODES, STATUS, TITLES
from modallab.core.errors import ModalLabError

BEAM = {
    "kind": "beam",
    "length": 1.5,
    "n_elements": 4,
    "section": {"area": 5e-4, "second_moment": 4.1667e-9},
    "material": {"modulus": 2.09e11, "density": 7800.0},
}


def subclasses(cls: type[ModalLabError]) -> list[type[ModalLabError]]:
    """Return a class of errors and all that derive from it."""
    return [cls, *(inner for child in cls.__subclasses__() for inner in subclasses(child))]


def test_every_code_has_a_title_in_words() -> None:
    codes = {cls.code for cls in subclasses(ModalLabError) if cls.__module__.startswith("modallab.")}
    assert codes | set(CODES.values()) | {"internal", "invalid_request"} <= set(TITLES)
    assert {cls.code for cls in STATUS} <= set(TITLES)
    assert all(" " in title for title in TITLES.values())


def test_a_misspelt_field_names_those_allowed_and_the_nearest(service: Any) -> None:
    section = {"area": 5e-4, "second_momemt": 4.1667e-9}
    problem = service.post("/v1/structures", BEAM | {"section": section}, status=422)
    assert problem["detail"] == (
        "body.beam.section.second_momemt: there is no such field; did you mean `second_moment`?"
    )
    context = problem["context"]
    assert context["value"] == 4.1667e-9
    assert context["allowed"] == ["area", "second_moment", "shear_coefficient"]
    assert problem["title"] == TITLES["invalid_request"]


def test_a_misspelt_field_of_one_alternative_names_those_of_that_alternative(service: Any, beam: str) -> None:
    changes = {"changes": [{"node": 7, "property": "mass", "valve": 0.05}]}
    problem = service.post(f"/v1/structures/{beam}/changes", changes, status=422)
    assert "did you mean `value`?" in str(problem["context"]["errors"])


VALUES: dict[str, tuple[dict[str, Any], Any, Any]] = {
    "a flag": ({"length": True}, True, None),
    "a number": ({"n_elements": 10**6}, 10**6, {"maximum": 2000}),
    "a list": ({"supports": [[1, 2]]}, [1, 2], None),
    "a name": ({"theory": "euler"}, "euler", ["bernoulli_euler", "timoshenko"]),
    "a long text": ({"length": "1" * 500}, "1" * 200, None),
}


@pytest.mark.parametrize("case", VALUES)
def test_a_refused_value_and_the_values_allowed_are_json(service: Any, case: str) -> None:
    changed, value, allowed = VALUES[case]
    context = service.post("/v1/structures", BEAM | changed, status=422)["context"]
    assert (context["value"], context["allowed"]) == (value, allowed)


def test_an_unknown_query_parameter_is_refused(service: Any) -> None:
    reply = service.request("GET", "/v1/structures", params={"limti": 3})
    problem = reply.json()
    assert (reply.status_code, problem["code"]) == (422, "invalid_request")
    assert problem["detail"] == "query.limti: there is no such field; did you mean `limit`?"
    assert problem["context"]["allowed"] == ["after", "label", "limit", "name", "owner"]


def test_an_unknown_field_of_a_form_is_refused(service: Any) -> None:
    reply = service.request(
        "POST", "/v1/structures/import", files={"file": ("a.bdf", b"")}, data={"dampign": "{}"}
    )
    problem = reply.json()
    assert (reply.status_code, problem["code"]) == (422, "invalid_request")
    assert problem["detail"] == "body.dampign: there is no such field; did you mean `damping`?"


@pytest.mark.parametrize("sent", ["text/plain", "application/x-www-form-urlencoded", None])
def test_another_content_type_is_refused_with_the_one_to_send(service: Any, sent: str | None) -> None:
    headers = {} if sent is None else {"content-type": sent}
    reply = service.request("POST", "/v1/structures", content=b'{"kind": "beam"}', headers=headers)
    problem = reply.json()
    assert (reply.status_code, problem["code"]) == (415, "unsupported_media_type")
    assert problem["context"]["allowed"] == ["application/json"]
    assert "application/json" in problem["detail"]


def test_json_is_refused_where_a_file_is_taken(service: Any) -> None:
    reply = service.request("POST", "/v1/measurements/import", json={})
    assert reply.status_code == 415
    assert reply.json()["context"]["allowed"] == ["multipart/form-data"]


@pytest.mark.parametrize(
    ("path", "allowed"),
    [
        ("/v1/structures", "GET, POST"),
        ("/v1/structures/5f0c31", "DELETE, GET, PATCH"),
        ("/v1/jobs/5f0c31", "DELETE, GET"),
        ("/v1/health", "GET"),
    ],
)
def test_another_method_is_refused_with_all_that_are_allowed(service: Any, path: str, allowed: str) -> None:
    reply = service.request("PUT", path)
    assert (reply.status_code, reply.headers["allow"]) == (405, allowed)
    assert reply.json()["context"]["allowed"] == allowed.split(", ")
