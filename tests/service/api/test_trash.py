"""Deletion over HTTP: into the trash, and back."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from modallab.api.settings import ServiceSettings
from modallab.store.viewer import EVERYONE
from tests.service.api.authorisation import BEAM, RIG, School, discarded, fill, new_assignment, open_school
from tests.service.api.conftest import service_of

# Path and name of one thing of every kind, each before what it was made from.
MADE = (
    ("diagnoses", "diagnosis"),
    ("studies", "study"),
    ("updates", "update"),
    ("updates", "direct_update"),
    ("correlations", "correlation"),
    ("modal-models", "global_model"),
    ("measurements", "last measurement"),
    ("rigs", "last rig"),
)


pytestmark = pytest.mark.usefixtures("unpadded")


@pytest.fixture(scope="module")
def school(tmp_path_factory: pytest.TempPathFactory) -> Iterator[School]:
    """Two classes, and a student who has made everything."""
    with service_of(ServiceSettings(data=tmp_path_factory.mktemp("data"))) as service:
        school = open_school(service)
        fill(school)
        school.ids["last rig"] = school.made("/v1/rigs", RIG)
        test = {"structure_id": school.ids["structure"], "rig_id": school.ids["last rig"]}
        school.ids["last measurement"] = school.made("/v1/measurements", test | {"route": "expected"})
        yield school


def statuses(school: School, method: str, path: str, *callers: str) -> list[int]:
    return [school.send(caller, method, path).status_code for caller in callers]


def test_one_thing_of_every_kind_goes_and_comes_back(school: School) -> None:
    paths = {f"/v1/{plural}/{school.ids[name]}": school.ids[name] for plural, name in MADE}
    before = {path: school.send("student", "GET", path).json() for path in paths}
    for path in paths:
        assert school.send("student", "DELETE", path).status_code == 204, path
        reply = school.send("student", "GET", path)
        assert (reply.status_code, reply.json()["code"]) == (404, "not_found")
        assert "is in the trash until" in reply.json()["detail"]
    listed = school.send("student", "GET", "/v1/trash").json()["items"]
    assert [item["id"] for item in listed] == list(paths.values())[::-1]
    assert [item["kind"] for item in listed][:3] == ["rig", "measurement", "modal_model"]
    for path, id in reversed(paths.items()):
        assert school.send("student", "POST", f"/v1/trash/{id}/restore").status_code == 200, path
        assert school.send("student", "GET", path).json() == before[path]
    assert school.send("student", "GET", "/v1/trash").json() == {"items": [], "next": None}


def test_what_it_was_made_from_comes_back_first(school: School) -> None:
    base = school.made("/v1/structures", BEAM)
    body = {"changes": [{"members": [1], "property": "modulus", "factor": 1.1}]}
    changed = school.made(f"/v1/structures/{base}/changes", body)
    assert school.send("student", "DELETE", f"/v1/structures/{base}").json()["code"] == "in_use"
    for id in (changed, base):
        assert school.send("student", "DELETE", f"/v1/structures/{id}").status_code == 204
    reply = school.send("student", "POST", f"/v1/trash/{changed}/restore")
    assert (reply.status_code, reply.json()["code"]) == (409, "in_trash")
    assert school.send("student", "DELETE", f"/v1/trash/{base}").json()["code"] == "in_use"
    assert school.send("student", "DELETE", f"/v1/trash/{changed}").status_code == 204
    assert school.send("student", "DELETE", f"/v1/trash/{base}").status_code == 204
    gone = school.send("student", "GET", f"/v1/structures/{base}").json()
    assert gone["detail"].startswith(f"there is no structure '{base}'")


def test_an_instructor_sees_and_restores_what_a_student_deleted(school: School) -> None:
    id = discarded(school)
    own = school.send("instructor", "GET", "/v1/trash").json()["items"]
    assert own == []
    wanted = f"/v1/trash?owner={school.ids['student']}"
    assert id in [item["id"] for item in school.send("instructor", "GET", wanted).json()["items"]]
    assert school.send("same class", "GET", wanted).json()["items"] == []
    assert statuses(school, "POST", f"/v1/trash/{id}/restore", "same class", "instructor") == [404, 200]


def test_what_was_shared_is_shared_again_when_it_is_restored(school: School) -> None:
    shared = school.made("/v1/structures", BEAM, "instructor")
    school.service.app.state.classes.share(school.ids["class"], shared, viewer=EVERYONE)
    path, roll = f"/v1/structures/{shared}", f"/v1/classes/{school.ids['class']}"
    assert statuses(school, "GET", path, "student", "instructor") == [200, 200]
    assert school.send("student", "DELETE", path).status_code == 403
    school.send("instructor", "DELETE", path)
    assert shared not in school.send("instructor", "GET", roll).json()["shares"]
    reply = school.send("student", "GET", path)
    # the trash is its owner's
    assert reply.json()["detail"].startswith(f"there is no structure '{shared}'")
    reply = school.send("instructor", "POST", f"{roll}/shares", json={"resource_id": shared})
    assert reply.status_code == 404
    school.send("instructor", "POST", f"/v1/trash/{shared}/restore")
    assert school.send("student", "GET", path).status_code == 200


def test_neither_structure_nor_measurement_of_an_assignment_is_deleted(school: School) -> None:
    assignment = new_assignment(school)
    measured = school.made(f"/v1/assignments/{assignment}/measurements", {})
    path = f"/v1/measurements/{measured}"
    assert statuses(school, "DELETE", path, "student", "instructor", "admin") == [409, 409, 409]
    assert school.send("student", "GET", path).status_code == 200
    structure = school.send("instructor", "GET", f"/v1/assignments/{assignment}").json()["structure_id"]
    assert school.send("instructor", "DELETE", f"/v1/structures/{structure}").status_code == 409


def test_a_rig_of_an_assignment_that_was_deleted_can_be_chosen_again(school: School) -> None:
    assignment = new_assignment(school)
    path = f"/v1/assignments/{assignment}/measurements"
    measured = school.made(path, {})
    rig = school.send("student", "GET", f"/v1/measurements/{measured}").json()["rig_id"]
    assert school.send("student", "DELETE", f"/v1/rigs/{rig}").status_code == 409
    assert school.made(path, {}) != measured


@pytest.fixture
def small(tmp_path: Path) -> Iterator[School]:
    """A service that stores little for each key."""
    with service_of(ServiceSettings(data=tmp_path, key_stored_bytes=20_000)) as service:
        yield open_school(service)


def test_the_trash_counts_and_gives_way_where_room_is_needed(small: School) -> None:
    def made() -> Any:
        return small.send("student", "POST", "/v1/structures", json=BEAM)

    kept = small.made("/v1/rigs", RIG)
    ids = [made().json()["id"] for _ in range(2)]
    for id in ids:
        small.send("student", "DELETE", f"/v1/structures/{id}")
    assert len(small.send("student", "GET", "/v1/trash").json()["items"]) == 2  # there is room
    n = 0
    while small.send("student", "GET", "/v1/trash").json()["items"]:
        assert made().status_code == 201
        n += 1
        assert n < 100
    while (reply := made()).status_code == 201:
        n += 1
        assert n < 100
    assert reply.json()["code"] == "storage_quota"
    assert small.send("student", "GET", f"/v1/rigs/{kept}").status_code == 200
