"""Project files: a zip with a list of contents, and of each thing its JSON and its arrays as in the store."""

import json
import re
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import IO, Any, NoReturn

from pydantic import ValidationError

import modallab
from modallab.api.projects.schemas import ProjectIn, ThingIn
from modallab.api.projects.settings import PROJECT
from modallab.core.errors import InvalidInputError, JsonValue, bounds
from modallab.interchange.npz_arrays import Arrays, load
from modallab.store.base import Entry, Store
from modallab.store.exported import ProjectContents

_MANIFEST = "project.json"
_KEPT = ("id", "kind", "version", "seed", "inputs", "name", "labels", "comment")
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_NUL = re.compile(r"(?<!\\)(?:\\\\)*\\u0000")


def write_project(store: Store, project: ProjectContents, file: IO[bytes], *, largest: int) -> None:
    """Write things as a project file.

    Parameters
    ----------
    largest
        Bytes that the file may have to be taken by an import.

    Raises
    ------
    InvalidInputError
        If it would have more.
    """
    if len(project.entries) > PROJECT.max_things:
        raise _too_large("objects", len(project.entries), PROJECT.max_things)
    n_bytes = PROJECT.overhead_bytes
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in _members(store, project):
            n_bytes += len(content) + PROJECT.overhead_bytes
            if n_bytes > largest:
                raise _too_large("bytes", n_bytes, largest)
            if name.endswith(".json") and len(content) > PROJECT.max_json_bytes:
                raise _too_large("bytes of JSON in one piece", len(content), PROJECT.max_json_bytes)
            method = zipfile.ZIP_STORED if name.endswith(".npz") else zipfile.ZIP_DEFLATED
            archive.writestr(zipfile.ZipInfo(name), content, method)


def _members(store: Store, project: ProjectContents) -> Iterator[tuple[str, bytes]]:
    things = [_described(entry) for entry in project.entries]
    contents = {"format": 1, "version": modallab.__version__, "things": things}
    yield _MANIFEST, json.dumps(contents | {"left_out": project.left_out}).encode()
    for entry in project.entries:
        parts = store.projects.parts(entry.id)
        yield f"{entry.id}.json", json.dumps({"body": parts.body, "request": parts.request}).encode()
        if parts.arrays:
            yield f"{entry.id}.npz", parts.arrays


def _described(entry: Entry) -> dict[str, Any]:
    return {name: getattr(entry, name) for name in _KEPT}


def _too_large(unit: str, value: int, largest: int) -> InvalidInputError:
    return InvalidInputError(
        f"this is too much for one file, which has at most {largest} {unit}: export things of one label",
        field="label",
        value=value,
        allowed=bounds(maximum=largest, unit=unit),
    )


class ProjectFile:
    """A project file of unknown origin."""

    def __init__(self, archive: zipfile.ZipFile, largest: int) -> None:
        self._archive, self._largest = archive, largest
        self._infos = {info.filename: info for info in archive.infolist()}
        total = sum(info.file_size for info in archive.infolist())
        if total > largest:
            raise refusal("the file is too large when unpacked", value=total, allowed=bounds(maximum=largest))
        self.contents = self._contents()

    def _contents(self) -> ProjectIn:
        try:
            contents = ProjectIn.model_validate(self._json(_MANIFEST))
        except ValidationError as error:
            first = error.errors()[0]
            place = ".".join(map(str, first["loc"]))
            raise refusal(f"{_MANIFEST}: {place}: {first['msg']}", field=place or "file") from None
        known = set[str]()
        for thing in contents.things:
            if thing.id in known:
                raise refusal(f"{thing.id} is there twice", value=thing.id)
            if missing := sorted(set(thing.inputs.values()) - known):
                raise refusal(f"{thing.id} comes before what it was made from", value=missing[0])
            known.add(thing.id)
        return contents

    def parts(self, thing: ThingIn) -> tuple[Any, Any, Arrays]:
        """Return body, request and arrays of a thing."""
        parts = self._json(f"{thing.id}.json")
        if not isinstance(parts, dict) or parts.keys() != {"body", "request"}:
            raise refusal(f"{thing.id}.json lacks body or request", value=thing.id)
        name = f"{thing.id}.npz"
        return parts["body"], parts["request"], self._arrays(name) if name in self._infos else {}

    def _arrays(self, name: str) -> Arrays:
        payload = self._bytes(name)
        with self._archive.open(self._infos[name]) as file, zipfile.ZipFile(file) as archive:
            names = [info.filename.removesuffix(".npy") for info in archive.infolist()]
        arrays = load(payload, names, self._largest)
        if any(array.dtype.kind not in "biufcU" for array in arrays.values()):
            raise refusal(f"{name} holds what is neither numbers nor text", value=name)
        return arrays

    def _json(self, name: str) -> Any:
        if name in self._infos and self._infos[name].file_size > PROJECT.max_json_bytes:
            allowed = bounds(maximum=PROJECT.max_json_bytes, unit="bytes")
            raise refusal(f"{name} is too large", value=self._infos[name].file_size, allowed=allowed)
        tree = json.loads(self._bytes(name), parse_constant=_refuse_constant)
        text = json.dumps(tree, ensure_ascii=False)
        text.encode()  # halves of characters cannot be stored
        if _NUL.search(text):
            raise refusal(f"{name} holds a character of code 0", value=name)
        return tree

    def _bytes(self, name: str) -> bytes:
        info = self._infos.get(name)
        if info is None:
            raise refusal(f"the file lacks {name}", value=name)
        if info.compress_type not in _METHODS:
            raise refusal(f"{name} is compressed by another method", allowed="deflate, or none")
        with self._archive.open(info) as member:
            return member.read(info.file_size)


@contextmanager
def opened(file: IO[bytes], *, largest: int) -> Iterator[ProjectFile]:
    """Yield a project file with a list of contents that fits together.

    Parameters
    ----------
    largest
        Bytes that it may have when unpacked.

    Raises
    ------
    InvalidInputError
        If it is no project file, is damaged, or holds too much.
    """
    with faults_of_file("the file"):
        archive = zipfile.ZipFile(file)
        project = ProjectFile(archive, largest)
    with archive:
        yield project


@contextmanager
def faults_of_file(what: str) -> Iterator[None]:
    """Raise `InvalidInputError` in place of whatever a file of unknown origin leads to."""
    try:
        yield
    except (InvalidInputError, MemoryError):
        raise
    except Exception as error:  # decompressors and constructors raise a dozen kinds at hostile bytes
        told = str(error)[:200] or type(error).__name__
        raise refusal(f"{what} is damaged, or of a later version: {told}") from None


def refusal(message: str, **context: JsonValue) -> InvalidInputError:
    """Return the error of a file that is refused."""
    return InvalidInputError(
        message, **({"field": "file", "allowed": "a file of GET /v1/projects/export"} | context)
    )


def _refuse_constant(name: str) -> NoReturn:
    raise refusal(f"{name} is no number of JSON", value=name)


def renamed(inputs: Mapping[str, str], ids: Mapping[str, str]) -> dict[str, str]:
    """Return what a thing was made from, by the ids that these have now."""
    return {role: ids[id] for role, id in inputs.items()}
