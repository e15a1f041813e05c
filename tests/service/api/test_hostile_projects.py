"""Project files that nobody should have written: refused, and nothing is left of them."""

import io
import json
import zipfile
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from modallab.api.projects.router import SHELVES
from modallab.api.settings import ServiceSettings
from modallab.store.npz import pack, unpack
from tests.service.api.authorisation import BEAM, fill, open_school
from tests.service.api.conftest import Service, service_of
from tests.service.api.project_files import Files, files_of, form, listed, path_of, zipped

pytestmark = pytest.mark.usefixtures("unpadded")


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service without keys that takes small files only."""
    data = tmp_path_factory.mktemp("elsewhere")
    with service_of(ServiceSettings(data=data, upload_limit=40_000_000)) as service:
        yield service


def changed(name: str, change: Callable[[Any], object]) -> Callable[[Files], object]:
    """Return the change of the JSON in a file."""

    def apply(files: Files) -> None:
        tree = json.loads(files[name])
        change(tree)
        files[name] = json.dumps(tree).encode()

    return apply


def contents(**fields: Any) -> Callable[[Files], object]:
    return changed("project.json", lambda tree: tree.update(fields))


def thing(**fields: Any) -> Callable[[Files], object]:
    return changed("project.json", lambda tree: tree["things"][0].update(fields))


def body(**fields: Any) -> Callable[[Files], object]:
    return changed("s1.json", lambda tree: tree["body"].update(fields))


def twice(tree: Any) -> None:
    tree["things"] *= 2


def deep(files: Files) -> None:
    files["s1.json"] = b'{"request": null, "body": ' + b"[" * 100_000 + b"]" * 100_000 + b"}"


HOSTILE: dict[str, Callable[[Files], object]] = {
    "no list of contents": lambda files: files.pop("project.json"),
    "list that is no JSON": lambda files: files.update({"project.json": b"{"}),
    "later format": contents(format=2),
    "unknown field": contents(more=1),
    "unknown kind": thing(kind="key"),
    "foreign owner": thing(owner="admin"),
    "name too long": thing(name="n" * 101),
    "label of control characters": thing(labels=["\n"]),
    "seed beyond a word": thing(seed=2**63),
    "thing of nothing": thing(inputs={"structure_id": "s0"}),
    "thing of itself": thing(inputs={"structure_id": "s1"}),
    "path as id": thing(id="../../s1"),
    "twice the same": changed("project.json", twice),
    "missing thing": lambda files: files.pop("s1.json"),
    "number that is none": lambda files: files.update({"s1.json": b'{"body": NaN, "request": null}'}),
    "depth": deep,
    "length": lambda files: files.update({"s1.json": files["s1.json"] + b" " * 21_000_000}),
    "half a character": body(name="\ud800"),
    "character of code 0": body(name="a\0"),
    "other type": body(**{"$type": "Diagnosis"}),
    "unknown element of a type": body(owner="admin"),
    "negative mass": body(masses=[{"$type": "PointMass", "node": 1, "mass": -1.0}]),
    "unknown node": body(masses=[{"$type": "PointMass", "node": 99, "mass": 1.0}]),
    "unknown effect": body(effects=[{"$type": "EffectSpec", "kind": "no", "at": None, "parameters": {}}]),
    "missing array": body(blocks={"$array": "blocks"}),
    "no members": body(members=[]),
    "request of something else": changed("s1.json", lambda tree: tree.update(request={"kind": "key"})),
    "arrays that are no archive": lambda files: files.update({"s1.npz": b"PK"}),
    "pickled array": lambda files: files.update({"s1.npz": pickled()}),
    "array of nothing known": lambda files: files.update(
        {"s1.npz": pack({"blocks": np.zeros(1, dtype="M8[s]")})}
    ),
}


def pickled() -> bytes:
    file = io.BytesIO()
    np.savez(file, blocks=np.array([{}], dtype=object))
    return file.getvalue()


@pytest.fixture(scope="module")
def simple(elsewhere: Service) -> Files:
    """A project file of one structure, `s1`."""
    elsewhere.request(
        "PATCH", f"/v1/structures/{elsewhere.post('/v1/structures', BEAM)['id']}", json={"labels": ["simple"]}
    )
    files = files_of(elsewhere.request("GET", "/v1/projects/export?label=simple").content)
    (id,) = [name.removesuffix(".json") for name in files if name != "project.json"]
    return {name.replace(id, "s1"): text.replace(id.encode(), b"s1") for name, text in files.items()}


def kept(service: Service) -> tuple[int, int]:
    """Return the numbers of things and of array files that a service keeps."""
    store, folder = service.app.state.store, service.app.state.settings.store_place.folder
    n_things = sum(len(getattr(store, shelf).list(limit=500)) for shelf in SHELVES.values())
    return n_things, sum(path.is_file() for path in folder.rglob("*"))


def refused(service: Service, content: bytes) -> Any:
    """Return the problem of a file that leaves nothing behind."""
    before = kept(service)
    reply = service.request("POST", "/v1/projects/import", **form(content))
    assert reply.status_code == 422, reply.text
    assert kept(service) == before
    return reply.json()


def test_the_simple_file_is_good(simple: Files, elsewhere: Service) -> None:
    assert elsewhere.request("POST", "/v1/projects/import", **form(zipped(simple))).status_code == 201


@pytest.mark.parametrize("case", HOSTILE)
def test_a_hostile_file_is_refused(case: str, simple: Files, elsewhere: Service) -> None:
    files = dict(simple)
    HOSTILE[case](files)
    problem = refused(elsewhere, zipped(files))
    assert problem["code"] in ("invalid_input", "structure", "unknown_dof"), problem


def test_a_damaged_file_is_refused(simple: Files, elsewhere: Service) -> None:
    whole = zipped(simple)
    for content in (b"", b"PK", whole[: len(whole) // 2], whole[:100] + b"\xff" * 40 + whole[140:]):
        refused(elsewhere, content)


def test_a_file_that_unpacks_to_more_than_may_be_sent_is_refused(simple: Files, elsewhere: Service) -> None:
    bomb = zipped({**simple, "s1.npz": bytes(50_000_000)})
    assert len(bomb) < 100_000
    assert refused(elsewhere, bomb)["context"]["value"] > 50_000_000


def test_other_compressions_are_refused(simple: Files, elsewhere: Service) -> None:
    refused(elsewhere, zipped(simple, zipfile.ZIP_LZMA))


def test_a_thing_that_is_bad_keeps_the_good_ones_out(simple: Files, elsewhere: Service) -> None:
    contents = json.loads(simple["project.json"])
    contents["things"].append(contents["things"][0] | {"id": "s2", "inputs": {"structure_id": "s1"}})
    bad = simple["s1.json"].replace(b'"modulus"', b'"moduli"')
    assert bad != simple["s1.json"]
    files = {**simple, "project.json": json.dumps(contents).encode(), "s2.json": bad}
    assert refused(elsewhere, zipped(files))["detail"].startswith("s2 is damaged")


VALUES: tuple[Any, ...] = (None, True, -1, 10**30, 1e300, "x", [], {}, {"$float": "nan"}, {"$array": "freq"})
PARTS = {
    "structure": ("", "/modes", "/geometry"),
    "measurement": ("", "/arrays.h5", "/curves", "/log", "/estimates"),
    "modal_model": ("", "/modes.uff"),
    "diagnosis": ("", "/report"),
}


def places(tree: Any) -> Iterator[tuple[Any, Any]]:
    """Yield every part of a tree of JSON, as what holds it and its key there."""
    for key in list(tree) if isinstance(tree, dict) else range(len(tree)) if isinstance(tree, list) else ():
        yield tree, key
        yield from places(tree[key])


def spoil(files: Files, id: str, rng: np.random.Generator) -> None:
    """Change one value of a thing, or the shape or the values of one of its arrays."""
    if f"{id}.npz" in files and rng.random() < 0.5:
        arrays = unpack(files[f"{id}.npz"])
        name = rng.choice(list(arrays))
        changes = (arrays[name][None], arrays[name].ravel()[:-1], np.full(arrays[name].shape, np.nan))
        arrays[name] = changes[rng.integers(len(changes))]
        files[f"{id}.npz"] = pack(arrays)
        return
    tree = json.loads(files[f"{id}.json"])
    found = list(places(tree["body"]))
    holder, key = found[rng.integers(len(found))]
    holder[key] = VALUES[rng.integers(len(VALUES))]
    files[f"{id}.json"] = json.dumps(tree).encode()


def test_a_spoilt_thing_is_refused_or_can_be_read(service: Service) -> None:
    school, rng = open_school(service), np.random.default_rng(1)
    fill(school)
    whole = school.send("student", "GET", "/v1/projects/export").content
    things = listed(whole)
    n_refused = 0
    for id, thing in [*things.items()] * 12:
        files = files_of(whole)
        spoil(files, id, rng)
        reply = school.send("student", "POST", "/v1/projects/import", **form(zipped(files)))
        assert reply.status_code in (201, 422), reply.text
        n_refused += reply.status_code == 422
        for part in PARTS.get(thing["kind"], ("",)) if reply.status_code == 201 else ():
            path = path_of(thing["kind"], reply.json()["ids"][id])
            assert school.send("student", "GET", path + part).status_code < 500, (path, part)
    assert n_refused > 50  # of 144: the others changed a number or a text to another
