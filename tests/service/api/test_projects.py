"""Projects over HTTP: out of one service as a file, and into another."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from modallab.api.projects.router import SHELVES
from modallab.api.settings import ServiceSettings
from tests.service.api.authorisation import BEAM, School, fill, new_assignment, open_school
from tests.service.api.conftest import Service, service_of
from tests.service.api.project_files import files_of, form, listed, path_of, zipped

pytestmark = pytest.mark.usefixtures("unpadded")
HIDDEN = {"kind": "extra_mass", "at": "4:+Y", "parameters": {"mass": 0.0517}}


@pytest.fixture(scope="module")
def school(tmp_path_factory: pytest.TempPathFactory) -> Iterator[School]:
    """Two classes, and a student who has made everything, a measurement of an assignment too."""
    with service_of(ServiceSettings(data=tmp_path_factory.mktemp("data"))) as service:
        school = open_school(service)
        fill(school)
        ids = school.ids
        test = {"structure_id": ids["structure"], "rig_id": ids["rig"], "route": "expected"}
        ids["hiding"] = school.made("/v1/measurements", test | {"effects": [HIDDEN]})
        change = {"changes": [{"members": [1], "property": "modulus", "factor": 1.1}]}
        ids["changed"] = school.made(f"/v1/structures/{ids['structure']}/changes", change)
        said = {"name": "first", "labels": ["autumn"], "comment": "bent"}
        school.send("student", "PATCH", f"/v1/modal-models/{ids['global_model']}", json=said)
        ids["sealed"] = school.made(f"/v1/assignments/{new_assignment(school)}/measurements", {})
        extraction = {"measurement_id": ids["sealed"], "n_modes": 2, "method": "lscf"}
        ids["of sealed"] = school.made("/v1/modal-models", extraction)
        yield school


@pytest.fixture(scope="module")
def content(school: School) -> bytes:
    """The project file of the student."""
    reply = school.send("student", "GET", "/v1/projects/export")
    assert (reply.status_code, reply.headers["content-type"]) == (200, "application/octet-stream")
    return bytes(reply.content)


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """Another service, without keys."""
    data = tmp_path_factory.mktemp("elsewhere")
    with service_of(ServiceSettings(data=data)) as service:
        yield service


def test_everything_is_the_same_elsewhere(school: School, content: bytes, elsewhere: Service) -> None:
    reply = elsewhere.request("POST", "/v1/projects/import", **form(content))
    assert reply.status_code == 201, reply.text
    ids, things = reply.json()["ids"], listed(content)
    assert ids.keys() == things.keys()
    assert {thing["kind"] for thing in things.values()} == SHELVES.keys()
    assert sum(reply.json()["counts"].values()) == len(things) >= 14
    assert not set(ids.values()) & set(ids)
    for id, thing in things.items():
        before = school.send("student", "GET", path_of(thing["kind"], id))
        expected = before.text
        for former, new in ids.items():
            expected = expected.replace(former, new)
        wanted, found = json.loads(expected), elsewhere.get(path_of(thing["kind"], ids[id]))
        assert (found.pop("owner"), wanted.pop("owner")) == ("local", school.ids["student"])
        assert found.pop("created") > wanted.pop("created")
        assert found == wanted, thing
        stores = school.service.app.state.store, elsewhere.app.state.store
        arrays = [
            getattr(store, SHELVES[thing["kind"]]).npz(own)
            for store, own in zip(stores, (id, ids[id]), strict=True)
        ]
        assert arrays[0] == arrays[1], thing
    again = elsewhere.get(f"/v1/structures/{ids[school.ids['structure']]}/body")
    assert again == BEAM
    described = elsewhere.get(f"/v1/modal-models/{ids[school.ids['global_model']]}")
    assert (described["name"], described["labels"], described["comment"]) == ("first", ["autumn"], "bent")


def test_work_goes_on_with_what_was_imported(school: School, content: bytes, elsewhere: Service) -> None:
    ids = elsewhere.request("POST", "/v1/projects/import", **form(content)).json()["ids"]
    body = {"measurement_id": ids[school.ids["measurement"]], "n_modes": 2, "method": "lscf"}
    assert elsewhere.result_of("/v1/modal-models", body)
    assert elsewhere.request("DELETE", f"/v1/structures/{ids[school.ids['structure']]}").status_code == 409


def test_no_truth_is_in_the_file(school: School, content: bytes) -> None:
    id = school.ids["hiding"]
    assert id in listed(content)
    text = files_of(content)[f"{id}.json"].decode()
    assert "extra_mass" not in text
    assert "0.0517" not in text
    assert school.ids["structure"] not in text


def test_measurements_of_assignments_and_what_came_of_them_are_left_out(
    school: School, content: bytes
) -> None:
    sealed = {school.ids["sealed"], school.ids["of sealed"]}
    assert set(json.loads(files_of(content)["project.json"])["left_out"]) == sealed
    assert not sealed & listed(content).keys()
    assert not any(
        id.encode() in file
        for id in sealed
        for name, file in files_of(content).items()
        if name != "project.json"
    )


def test_a_sealed_measurement_is_not_diagnosed_as_ones_own_upload(school: School, content: bytes) -> None:
    own, files = school.ids["measurement"], files_of(content)
    files[f"{own}.npz"] = school.service.app.state.store.measurements.npz(school.ids["sealed"])
    ids = school.send("same class", "POST", "/v1/projects/import", **form(zipped(files))).json()["ids"]
    body = {"structure_id": ids[school.ids["structure"]], "measurement_id": ids[own]}
    reply = school.send("same class", "POST", "/v1/diagnoses", json=body)
    assert (reply.status_code, reply.json()["code"]) == (422, "assignment"), reply.text


def test_nobody_exports_what_another_has(school: School, content: bytes) -> None:
    own = set(listed(content))
    for caller in ("same class", "other student", "instructor", "admin"):
        reply = school.send(caller, "GET", "/v1/projects/export")
        assert not own & listed(reply.content).keys(), caller
    shared = school.ids["share"]
    assert school.send("same class", "GET", f"/v1/structures/{shared}").status_code == 200
    body = {"changes": [{"members": [1], "property": "modulus", "factor": 1.1}]}
    made = school.made(f"/v1/structures/{shared}/changes", body, "same class")
    reply = school.send("same class", "GET", "/v1/projects/export")
    assert json.loads(files_of(reply.content)["project.json"])["left_out"] == [made]


def test_what_is_imported_belongs_to_who_imports_it(school: School, content: bytes) -> None:
    ids = school.send("other student", "POST", "/v1/projects/import", **form(content)).json()["ids"]
    for former, new in ids.items():
        path = path_of(listed(content)[former]["kind"], new)
        assert school.send("other student", "GET", path).json()["owner"] == school.ids["other student"]
        assert school.send("student", "GET", path).status_code == 404


def test_a_label_brings_what_it_was_made_from(school: School) -> None:
    reply = school.send("student", "GET", "/v1/projects/export?label=autumn")
    ids = school.ids
    assert set(listed(reply.content)) == {ids["global_model"], ids["measurement"], ids["rig"]}
    assert listed(school.send("student", "GET", "/v1/projects/export?label=winter").content) == {}


def test_what_is_in_the_trash_stays_there(school: School) -> None:
    id = school.made("/v1/structures", BEAM)
    school.send("student", "DELETE", f"/v1/structures/{id}")
    assert id not in listed(school.send("student", "GET", "/v1/projects/export").content)


def test_more_than_an_import_takes_is_not_exported(tmp_path: Path) -> None:
    with service_of(ServiceSettings(data=tmp_path, upload_limit=20_000)) as small:
        for _ in range(20):
            small.post("/v1/structures", BEAM)
        reply = small.request("GET", "/v1/projects/export")
        assert (reply.status_code, reply.json()["context"]["allowed"]["maximum"]) == (422, 20_000)
