"""Names, labels and remarks: given to anything stored, and found by lists."""

from typing import Any

import pytest

BODY = {"name": "First Test", "labels": ["autumn", 'group "3"'], "comment": "the stinger was bent\n100 %"}


@pytest.fixture(scope="module")
def rigs(service: Any) -> list[str]:
    """Three rigs, the first two of them described."""
    ids = [service.post("/v1/rigs", {"drive": "1:+Y", "responses": [f"{n}:+Y"]})["id"] for n in range(1, 4)]
    others = {"name": "second_test", "labels": ["autumn", 'group \\"3']}
    for id, body in zip(ids, (BODY, others), strict=False):
        assert service.request("PATCH", f"/v1/rigs/{id}", json=body).status_code == 200
    return ids


def found(service: Any, **query: str) -> list[str]:
    return [item["id"] for item in service.get("/v1/rigs", params=query)["items"]]


def test_a_description_is_in_the_list_and_in_the_reply(service: Any, rigs: list[str]) -> None:
    for entry in (service.get(f"/v1/rigs/{rigs[0]}"), service.get("/v1/rigs")["items"][-1]):
        assert {name: entry[name] for name in BODY} == BODY
    bare = service.get(f"/v1/rigs/{rigs[2]}")
    assert (bare["name"], bare["labels"], bare["comment"]) == ("", [], "")


def test_what_is_left_out_stays(service: Any, rigs: list[str]) -> None:
    path = f"/v1/rigs/{rigs[0]}"
    changed = service.request("PATCH", path, json={"comment": ""}).json()
    assert (changed["name"], changed["labels"], changed["comment"]) == (BODY["name"], BODY["labels"], "")
    same = service.request("PATCH", path, json={})
    assert (same.status_code, same.json()) == (200, changed)
    service.request("PATCH", path, json={"comment": BODY["comment"]})


@pytest.mark.parametrize(
    ("query", "numbers"),
    [
        ({"name": "TEST"}, [1, 0]),
        ({"name": "d_t"}, [1]),
        ({"name": "%"}, []),
        ({"label": "autumn"}, [1, 0]),
        ({"label": "aut"}, []),
        ({"label": 'group "3"'}, [0]),
        ({"label": 'group \\"3'}, [1]),
        ({"label": "autumn", "name": "first"}, [0]),
        ({"owner": "local"}, [2, 1, 0]),
        ({"owner": "nobody"}, []),
    ],
)
def test_lists_are_filtered(service: Any, rigs: list[str], query: dict[str, str], numbers: list[int]) -> None:
    assert found(service, **query) == [rigs[number] for number in numbers]


def test_a_structure_has_its_own_name_until_it_is_given_another(service: Any) -> None:
    id = service.post("/v1/structures", {"kind": "catalogue", "name": "bay"})["id"]
    assert service.get(f"/v1/structures/{id}")["name"] == "bay"
    service.request("PATCH", f"/v1/structures/{id}", json={"name": "the hall's roof"})
    assert service.get(f"/v1/structures/{id}")["name"] == "the hall's roof"


@pytest.mark.parametrize(
    "body",
    [{"name": "x" * 101}, {"labels": [""]}, {"labels": ["x"] * 21}, {"comment": "x" * 2001}, {"title": "x"}],
)
def test_a_description_at_fault_changes_nothing(service: Any, rigs: list[str], body: Any) -> None:
    reply = service.request("PATCH", f"/v1/rigs/{rigs[0]}", json=BODY | body)
    assert (reply.status_code, reply.json()["code"]) == (422, "invalid_request")
    assert service.get(f"/v1/rigs/{rigs[0]}")["name"] == BODY["name"]
    assert service.request("PATCH", "/v1/rigs/none", json=BODY).status_code == 404
