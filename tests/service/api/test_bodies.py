"""The body that described a structure or a rig, sent again, makes the same one."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from modallab.api.settings import ServiceSettings
from modallab.store.viewer import EVERYONE
from tests.service.api.authorisation import School, assignment, open_school
from tests.service.api.conftest import service_of
from tests.service.api.test_structures import BEAM, FRAME, STEEL

PLATE = {
    "kind": "plate",
    "length": 0.6,
    "width": 0.4,
    "thickness": 0.004,
    "n_elements": [3, 2],
    "material": STEEL,
    "edges": {"left": "clamped"},
}
OF_A_CATALOGUE = {"kind": "catalogue", "name": "bay"}
EFFECT = {"kind": "extra_mass", "at": "7:+Y", "parameters": {"mass": 0.05}}
CHANGES = {"changes": [{"members": [1], "property": "modulus", "factor": 1.3}]}


@pytest.fixture
def school(tmp_path: Path) -> Iterator[School]:
    """A class of an empty service."""
    with service_of(ServiceSettings(data=tmp_path)) as service:
        yield open_school(service)


@pytest.mark.parametrize(
    "body", [BEAM | {"effects": [EFFECT]}, FRAME, PLATE, OF_A_CATALOGUE], ids=lambda body: body["kind"]
)
def test_a_structure_is_made_again_from_its_body(service: Any, body: dict[str, Any]) -> None:
    first = service.post("/v1/structures", body)["id"]
    told = service.get(f"/v1/structures/{first}/body")
    assert told == body
    again = service.post("/v1/structures", told)["id"]
    modes = [service.get(f"/v1/structures/{id}/modes") for id in (first, again)]
    assert modes[0]["frequencies"] == modes[1]["frequencies"]  # of the same numbers: to the last bit
    assert service.get(f"/v1/structures/{again}/body") == body


def test_a_changed_structure_has_the_body_of_its_changes(service: Any, beam: str) -> None:
    changed = service.post(f"/v1/structures/{beam}/changes", CHANGES)["id"]
    assert service.get(f"/v1/structures/{changed}/body") == CHANGES


def test_a_rig_is_made_again_from_its_body(service: Any, rig: str) -> None:
    again = service.post("/v1/rigs", service.get(f"/v1/rigs/{rig}/body"))
    own = ("id", "created")  # of each of both
    first = service.get(f"/v1/rigs/{rig}")
    assert {name: again[name] for name in again if name not in own} == {
        name: first[name] for name in first if name not in own
    }


def test_what_no_request_described_has_no_body(service: Any, beam: str) -> None:
    store = service.app.state.store
    computed = store.structures.add(store.structures.get(beam), owner="local")
    reply = service.request("GET", f"/v1/structures/{computed}/body")
    assert reply.status_code == 404
    assert "no request described" in reply.json()["detail"]
    assert reply.json()["context"]["value"] == computed


def test_a_shared_structure_keeps_its_description_to_its_owner(school: School) -> None:
    hidden = school.made("/v1/structures", BEAM | {"effects": [EFFECT]}, "instructor")
    school.service.app.state.classes.share(school.ids["class"], hidden, viewer=EVERYONE)
    path = f"/v1/structures/{hidden}"
    assert school.send("student", "GET", path).status_code == 200
    reply = school.send("student", "GET", f"{path}/body")
    assert reply.status_code == 403
    assert "extra_mass" not in reply.text
    assert school.send("instructor", "GET", f"{path}/body").json()["effects"] == [EFFECT]


def test_the_structure_of_an_assignment_keeps_its_description_to_its_instructor(school: School) -> None:
    structure = school.made("/v1/structures", BEAM | {"effects": [EFFECT]}, "instructor")
    body = assignment(school.ids["class"]) | {"structure": structure}
    assert school.send("instructor", "POST", "/v1/assignments", json=body).status_code == 201
    assert school.send("student", "GET", f"/v1/structures/{structure}").status_code == 200
    assert school.send("student", "GET", f"/v1/structures/{structure}/body").status_code == 403
