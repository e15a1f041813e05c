"""A service with keys: two classes of two instructors, and one thing of every kind that a student made."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import count
from typing import Any

from modallab.core.dof import Dof
from modallab.fe.catalogued import STRUCTURES
from modallab.rig.setup import RigSetup
from modallab.store.keys import KeyBook, NewKey, Role
from modallab.store.viewer import EVERYONE
from tests.diagnosed import diagnosis
from tests.service.api.conftest import Service

# In the order of the table: who asks for what the student owns.
CALLERS = ("no key", "other student", "same class", "instructor", "admin", "revoked", "expired")
BEAM: dict[str, Any] = {
    "kind": "beam",
    "length": 1.2,
    "n_elements": 8,
    "section": {"area": 5e-4, "second_moment": 4.1667e-9},
    "material": {"modulus": 2.09e11, "density": 7800.0},
    "damping": {"law": "structural", "stiffness_coefficient": 0.008},
}
POINTS = [f"{node}:+Y" for node in (1, 2, 4, 5, 7, 9)]
RIG: dict[str, Any] = {
    "drive": "1:+Y",
    "responses": POINTS,
    "analyser": {"frequency_max": 400.0, "n_lines": 161},
    "noise": {"force": 1e-4, "response": 1e-4},
}
PARTS = {"macros": [[1, 2, 3, 4], [5, 6, 7, 8]], "parts": ["stiffness"]}


@dataclass(frozen=True)
class School:
    """A service, keys by the names of their holders, and the ids of what one student has made."""

    service: Service
    keys: Mapping[str, str]
    ids: dict[str, str]

    def send(self, caller: str, method: str, path: str, **given: Any) -> Any:
        """Return the reply to a caller's request."""
        text = self.keys.get(caller)
        headers = {} if text is None else {"Authorization": f"Bearer {text}"}
        return self.service.request(method, path, headers=headers | given.pop("headers", {}), **given)

    def made(self, path: str, body: Any, caller: str = "student") -> str:
        """Return the id of what a caller makes, by a job or at once."""
        reply = self.send(caller, "POST", path, json=body)
        assert reply.is_success, reply.text
        if reply.status_code != 202:
            return str(reply.json()["id"])
        job = self.send(caller, "GET", f"/v1/jobs/{reply.json()['id']}").json()
        assert job["state"] == "succeeded", job
        self.ids["job"] = job["id"]
        return str(job["result_id"])


def open_school(service: Service) -> School:
    """Return the school of a service without keys, which then has some."""
    keys = KeyBook(service.app.state.keys._engine)
    ids: dict[str, str] = {}

    def add(caller: str, new: NewKey) -> tuple[str, str]:
        ids[caller] = new.key.id
        return caller, new.text

    texts = dict(add(role.value, keys.create(role.value, role)) for role in (Role.ADMIN, Role.SERVICE))
    for caller, name in (("instructor", "class"), ("other instructor", "other class")):
        new = keys.create(caller, Role.INSTRUCTOR)
        texts |= [add(caller, new)]
        ids[name] = service.app.state.classes.create(name, owner=new.key.id).id
    members = {"class": ("student", "same class", "revoked"), "other class": ("other student",)}
    for name, names in members.items():
        joined = service.app.state.classes.add_members(ids[name], names, viewer=EVERYONE)
        texts |= [add(new.key.name, new) for new in joined]
    keys.revoke(ids["revoked"], viewer=EVERYONE)
    texts |= [add("expired", keys.create("expired", Role.STUDENT, expires=datetime(2020, 1, 1, tzinfo=UTC)))]
    return School(service, texts, ids)


def fill(school: School) -> None:
    """Let the student make something of every kind."""
    ids, made = school.ids, school.made
    ids["structure"], ids["rig"] = made("/v1/structures", BEAM), made("/v1/rigs", RIG)
    test = {"structure_id": ids["structure"], "rig_id": ids["rig"], "route": "expected"}
    ids["measurement"] = made("/v1/measurements", test)
    extraction = {"measurement_id": ids["measurement"], "n_modes": 3}
    ids["modal_model"] = made("/v1/modal-models", extraction | {"method": "circle_fit"})
    ids["global_model"] = made("/v1/modal-models", extraction | {"method": "lscf"})
    pair = {"structure_id": ids["structure"], "modal_model_id": ids["modal_model"]}
    ids["correlation"] = made("/v1/correlations", pair)
    updating = pair | {"parameterisation": PARTS}
    ids["update"] = made(
        "/v1/updates", updating | {"method": "one_shot", "options": {"prior": "common", "samples": 50}}
    )
    ids["direct_update"] = made("/v1/updates", pair | {"method": "berman_nagy"})
    ids["study"] = made("/v1/studies", study(ids))
    made_from = {f"{name}_id": ids[name] for name in ("structure", "measurement")}
    made_from |= {"extended_structure_id": ids["structure"], "extended_rig_id": ids["rig"]}
    ids["diagnosis"] = school.service.app.state.store.diagnoses.add(
        diagnosis(), owner=ids["student"], inputs=made_from
    )
    ids["assignment"] = new_assignment(school)
    ids["share"] = throwaway(school, "structures")
    school.service.app.state.classes.share(ids["class"], ids["share"], viewer=EVERYONE)


def study(ids: Mapping[str, str]) -> dict[str, Any]:
    """Return the request of a study of one run."""
    levels = [{"name": "little", "eigenvalue": 0.001}]
    plan = {"levels": levels, "seeds": [1], "count": 4, "dofs": POINTS, "divisions": {"two": PARTS["macros"]}}
    return {"structure_id": ids["structure"], "truth_id": ids["structure"], **plan}


_NUMBERS = count()
_THINGS = {
    "structures": STRUCTURES["bay"](),
    "rigs": RigSetup(drives=(Dof(1, "Y"),), responses=(Dof(1, "Y"),)),
}


def throwaway(school: School, shelf: str) -> str:
    """Return the id of one more thing of the student's, which nothing else needs."""
    store, ids = school.service.app.state.store, school.ids
    of = {"structures": "structure", "rigs": "rig"}.get(shelf)
    thing = _THINGS[shelf] if of else getattr(store, shelf).get(ids[_SINGULAR[shelf]])
    return str(getattr(store, shelf).add(thing, owner=ids["student"]))


def discarded(school: School) -> str:
    """Return the id of one more structure of the student's, which is in the trash."""
    id = throwaway(school, "structures")
    school.service.app.state.store.structures.discard(id)
    return id


_SINGULAR = {
    "measurements": "measurement",
    "modal_models": "modal_model",
    "correlations": "correlation",
    "updates": "update",
    "studies": "study",
    "diagnoses": "diagnosis",
}


def new_member(school: School) -> str:
    """Return the id of the key of one more student of the class."""
    classes = school.service.app.state.classes
    name = f"member {next(_NUMBERS)}"
    return str(classes.add_members(school.ids["class"], [name], viewer=EVERYONE)[0].key.id)


def new_class(school: School) -> str:
    """Return the id of one more class of the instructor."""
    classes = school.service.app.state.classes
    return str(classes.create("another", owner=school.ids["instructor"]).id)


def new_share(school: School) -> str:
    """Return the id of one more structure that is shared with the class."""
    structure = throwaway(school, "structures")
    school.service.app.state.classes.share(school.ids["class"], structure, viewer=EVERYONE)
    return structure


def assignment(class_id: str) -> dict[str, Any]:
    """Return the body of an assignment with one drawn mass."""
    mass = {
        "kind": "extra_mass",
        "at": {"one_of": ["2:+Y", "7:+Y"]},
        "parameters": {"mass": {"between": [0.05, 0.2]}},
    }
    return {
        "class_id": class_id,
        "title": "Find the mass",
        "structure": BEAM,
        "rig": RIG,
        "hidden": [mass],
        "choices": {"drive": {"one_of": ["1:+Y", "9:+Y"]}, "analyser.averages": {"between": [5, 50]}},
        "quota": 3,
        "submissions": 2,
    }


def new_assignment(school: School) -> str:
    """Return the id of one more assignment of the class."""
    body = assignment(school.ids["class"])
    reply = school.send("instructor", "POST", "/v1/assignments", json=body)
    assert reply.status_code == 201, reply.text
    return str(reply.json()["id"])


def answered_assignment(school: School) -> str:
    """Return the id of one more assignment, which the student has answered in words."""
    body = assignment(school.ids["class"]) | {"rubric": {"words": 3}}
    id = str(school.send("instructor", "POST", "/v1/assignments", json=body).json()["id"])
    reply = school.send("student", "POST", f"/v1/assignments/{id}/submissions", json={"words": "bent"})
    assert reply.status_code == 201, reply.text
    return id


def student_id(school: School) -> str:
    """Return the id of the student's key."""
    rows = school.send("student", "GET", f"/v1/assignments/{school.ids['assignment']}/marks").json()["items"]
    return str(rows[0]["student"])
