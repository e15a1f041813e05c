"""Searches every byte that a student can get for what assignments hide from the student.

    python -m tests.faults.sealed --assignments 30

Each assignment hides one effect with a drawn value at a drawn place. The student measures, extracts modes,
correlates, updates, diagnoses where that is allowed, answers wrongly, and sends what is refused. Then every
GET of the API is asked about everything that the student has or has heard of.
"""

import argparse
import json
import re
import struct
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from modallab.api.settings import ServiceSettings
from modallab.jobs import sealing
from modallab.store.assignments import StoredAssignment
from modallab.store.viewer import EVERYONE
from tests.service.api.authorisation import BEAM, PARTS, RIG, School, open_school
from tests.service.api.conftest import service_of
from tests.service.api.test_authorisation import OPERATIONS, ROWS

PLACES = ["3:+Y", "6:+Y", "8:+Y"]  # not among the responses, which every reply may name
EFFECTS: Sequence[tuple[str, str, tuple[float, float]]] = (
    ("extra_mass", "mass", (0.05, 0.2)),
    ("ground_spring", "stiffness", (2e4, 9e4)),
    ("cubic_stiffness", "stiffness", (1e9, 5e9)),
    ("local_damping", "damping", (5.0, 50.0)),
    ("attached_oscillator", "mass", (0.02, 0.1)),
)
ID = re.compile(rb'"([0-9a-f]{24})"')
PATH_ID = re.compile(r"(?<=/)[0-9a-f]{24}")
CHANCE_BYTES = 4


@dataclass(frozen=True)
class Reply:
    """What a student got."""

    request: str
    status: int
    content: bytes


@dataclass(frozen=True)
class Secret:
    """Bytes that no reply may have."""

    name: str
    content: bytes
    unless: str = "nowhere"
    """Beginning of the requests whose replies have it for all."""
    is_number: bool = False
    """Whether it is a number in digits, which is no part of a longer one."""

    def is_in(self, content: bytes) -> bool:
        """Return whether a reply has it."""
        if self.content not in content:
            return False
        alone = rb"(?<![\d.])" + re.escape(self.content) + rb"(?!\d)"
        return not self.is_number or re.search(alone, content) is not None


def assigned(school: School, number: int) -> tuple[str, str]:
    """Return the ids of a new assignment and of its structure, with a hidden effect drawn for the student."""
    kind, parameter, limits = EFFECTS[number % len(EFFECTS)]
    effect = {"kind": kind, "at": {"one_of": PLACES}, "parameters": {parameter: {"between": limits}}}
    body = {
        "class_id": school.ids["class"],
        "title": f"Assignment {number}",
        "structure": BEAM,
        "rig": RIG | {"analyser": {"frequency_max": 400.0, "n_lines": 161, "averages": 20}},
        "hidden": [effect],
        "choices": {"drive": {"one_of": ["1:+Y", "9:+Y"]}},
        "quota": 2,
        "diagnosis": ("off", "after_deadline")[number % 2],
        "deadline": "2040-01-01T00:00:00Z",
        "reveal": "2040-01-02T00:00:00Z",
        "rubric": {"coefficients": 1, "expected": {"E": {"value": 0.87654321}}},
    }
    reply = school.send("instructor", "POST", "/v1/assignments", json=body)
    assert reply.status_code == 201, reply.text
    return str(reply.json()["id"]), str(reply.json()["structure_id"])


def worked_on(school: School, id: str, structure: str) -> Iterator[Reply]:
    """Yield the replies to all that a student sends about an assignment."""

    def post(path: str, body: Any) -> Reply:
        reply = school.send("student", "POST", path, json=body)
        return Reply(f"POST {path}", reply.status_code, reply.content)

    def result(reply: Reply) -> str:
        job = school.send("student", "GET", f"/v1/jobs/{json.loads(reply.content)['id']}").json()
        assert job["state"] == "succeeded", job
        return str(job["result_id"])

    path = f"/v1/assignments/{id}"
    for rig in ({"drive": "9:+Y"}, {}):
        yield (started := post(f"{path}/measurements", {"rig": rig}))
        made = result(started)
    yield post(f"{path}/measurements", {})  # the quota is used up
    yield post(f"{path}/measurements", {"rig": {"drive": "2:+Y"}, "route": "expected"})
    yield (
        fitting := post("/v1/modal-models", {"measurement_id": made, "method": "circle_fit", "n_modes": 3})
    )
    pair = {"structure_id": structure, "modal_model_id": result(fitting)}
    yield post("/v1/correlations", pair)
    update = {"method": "one_shot", "parameterisation": PARTS, "options": {"prior": "common"}}
    yield post("/v1/updates", pair | update)
    ids = {"structure_id": structure, "measurement_id": made}
    yield post("/v1/updates", ids | {"method": "frf_residual", "parameterisation": PARTS})
    yield post("/v1/correlations", pair | ids)
    for act in (False, True):
        yield post("/v1/diagnoses", ids | {"act": act})
    wrong = {"kind": "density_error", "at": {"members": [1]}, "parameters": {"factor": 1.1}}
    yield post(f"{path}/submissions", {"effects": [wrong], "coefficients": {"E": 1.0}, "words": "so"})


def heard_of(replies: Sequence[Reply]) -> list[str]:
    """Return all ids that replies name, each once, in their order."""
    return list(dict.fromkeys(id.decode() for reply in replies for id in ID.findall(reply.content)))


def asked_for(school: School, ids: Sequence[str]) -> Iterator[Reply]:
    """Yield the replies to every GET of the API, about each of the ids."""
    for name, (method, path) in OPERATIONS.items():
        if method != "GET":
            continue
        query = ROWS[name].query
        paths = [path.replace("{id}", id) for id in ids] if "{id}" in path else [path]
        for each in paths:
            address = each.replace("{family}", "effects") + _filled(query, ids)
            for accept in ("*/*", "application/json") if "arrays" in address else ("*/*",):
                reply = school.send("student", "GET", address, headers={"Accept": accept})
                yield Reply(f"GET {address}", reply.status_code, reply.content)


def _filled(query: str, ids: Sequence[str]) -> str:
    return re.sub(r"\{\w+\}", ids[0] if ids else "", query)


def secrets(stored: StoredAssignment, student: str) -> Iterator[Secret]:
    """Yield what no reply may have: kind, place, values, seeds and the secret of an assignment."""
    yield Secret("secret", stored.secret.encode())
    for number in (1, 2):
        seed = stored.seed(student, number)
        yield Secret("seed", str(seed).encode())
        yield from (Secret("seed", struct.pack(order, seed)) for order in ("<q", ">q"))
    for effect in stored.hidden_from(student):
        # The catalogue and the page of the API's choices name all kinds; geometries all places.
        yield Secret("kind", effect.kind.encode(), "GET /v1/catalog/")
        yield Secret("place", f'"{effect.at}"'.encode(), "GET /v1/structures/")
        for value in effect.parameters.values():
            texts = {f"{value:.{digits}{form}}" for digits in range(6, 18) for form in "ge"}
            yield from (Secret("value", text.encode(), is_number=True) for text in (repr(value), *texts))
            yield from (Secret("value", struct.pack(order, value)) for order in ("<d", ">d", "<f", ">f"))
    for right in stored.assignment.rubric.expected.values():
        yield Secret("coefficient", repr(right.value).encode())


def found(replies: Sequence[Reply], hidden: Sequence[Secret]) -> list[str]:
    """Return where replies have what they may not.

    Four given bytes are in 33 MB by chance once in 130 searches, one of 60 such values in every other one. A
    student measures each assignment twice: bytes that tell a value are in replies about more than one thing.
    """
    told = []
    for secret in hidden:
        having = [r for r in replies if secret.is_in(r.content) and not r.request.startswith(secret.unless)]
        things = {match.group() if (match := PATH_ID.search(r.request)) else r.request for r in having}
        if len(things) > 1 or len(secret.content) > CHANCE_BYTES:
            told += [f"{secret.name} {secret.content!r} in {reply.request}" for reply in having]
    return told


def searched(school: School, n: int) -> tuple[list[Reply], list[Secret]]:
    """Return all that a student gets of so many assignments, and what may not be in it."""
    replies: list[Reply] = []
    hidden: list[Secret] = []
    for number in range(n):
        id, structure = assigned(school, number)
        replies += worked_on(school, id, structure)
        stored = school.service.app.state.assignments.get(id, viewer=EVERYONE)
        hidden += secrets(stored, school.ids["student"])
    replies += asked_for(school, [])
    replies += asked_for(school, heard_of(replies))
    return replies, hidden


def main() -> None:
    """Search, and print what was found."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    parser.add_argument("--assignments", type=int, default=30)
    options = parser.parse_args()
    sealing.SEALING = replace(sealing.SEALING, step=0.0)
    with tempfile.TemporaryDirectory() as folder, service_of(ServiceSettings(data=Path(folder))) as service:
        replies, hidden = searched(open_school(service), options.assignments)
    n_bytes = np.sum([len(reply.content) for reply in replies])
    told = found(replies, hidden)
    good = sum(reply.status < 300 for reply in replies)
    print(
        f"{options.assignments} assignments, {len(replies)} replies, {good} of them with content, "
        f"{n_bytes / 1e6:.1f} MB, {len(hidden)} secrets: {len(told)} found"
    )
    print("\n".join(told))


if __name__ == "__main__":
    main()
