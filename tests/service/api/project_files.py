"""Project files, taken apart and put together."""

import io
import json
import zipfile
from collections.abc import Mapping
from typing import Any

from modallab.api.projects.router import SHELVES

Files = dict[str, bytes]


def files_of(content: bytes) -> Files:
    """Return the files in a project file."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def zipped(files: Mapping[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    """Return a zip of files."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return file.getvalue()


def form(content: bytes) -> dict[str, Any]:
    """Return the form of an import."""
    return {"files": {"file": ("project.zip", content)}}


def listed(content: bytes) -> dict[str, dict[str, Any]]:
    """Return the things in a project file by their ids."""
    return {thing["id"]: thing for thing in json.loads(files_of(content)["project.json"])["things"]}


def path_of(kind: str, id: str) -> str:
    """Return the address of a thing."""
    return f"/v1/{SHELVES[kind].replace('_', '-')}/{id}"
