"""Arguments and options that several commands have, and files that are written."""

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from modallab_client.errors import InvalidInputError

PICTURES = (".png", ".svg", ".pdf")
FRF_FILES = (".uff", ".unv", ".npz", ".h5", ".hdf5", ".frf")
MODE_FILES = (".uff", ".unv", ".json")


def file_option(text: str, *names: str) -> Any:
    """Return an option that names a file to read."""
    return typer.Option(*names, exists=True, dir_okay=False, readable=True, help=text)


def file_argument(text: str) -> Any:
    """Return an argument that names a file to read."""
    return typer.Argument(exists=True, dir_okay=False, readable=True, help=text)


Model = Annotated[
    Path,
    file_option(
        "The model: .json, a body of POST /v1/structures; Nastran bulk data; a mesh, with --mesh; matrices."
    ),
]
MeshGroups = Annotated[
    Path | None,
    file_option("Of a mesh, JSON: sections, thicknesses and materials by group, supports, what is left out."),
]
Rig = Annotated[Path, file_option("The log book of the test: .json, a body of POST /v1/rigs.")]
OptionalRig = Annotated[
    Path | None, file_option("The log book of the test, as JSON; left out: what the file tells.")
]
Measured = Annotated[Path, file_argument("Measured FRFs: any format that an import takes.")]
Averages = Annotated[
    float | None, typer.Option(help="Effective averages; default: the file's, or else the rig's.")
]
Picture = Annotated[
    Path | None, typer.Option("--plot", help="Write a picture of the result: .png, .svg or .pdf.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print the whole result as JSON.")]
Server = Annotated[
    str | None,
    typer.Option(
        help="Address of a lab, http://host:8000, whose key is MODALLAB_KEY; left out: this computer."
    ),
]


def check_output(path: Path | None, endings: Sequence[str], field: str) -> None:
    """Raise `InvalidInputError` if a file cannot be written, before anything is computed for it."""
    if path is None:
        return
    if endings and path.suffix.lower() not in endings:
        allowed = ", ".join(endings)
        raise InvalidInputError(f"{field} {path}: the ending is none of {allowed}")
    folder = path.resolve().parent
    if not folder.is_dir():
        raise InvalidInputError(f"{field} {path}: there is no folder {folder}")
    if path.is_dir():
        raise InvalidInputError(f"{field} {path} is a folder")
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise InvalidInputError(f"{field} {path} must not be written")


def read_json(path: Path) -> Any:
    """Return the content of a JSON file.

    Raises
    ------
    InvalidInputError
        If it is no JSON.
    """
    try:
        return json.loads(path.read_bytes())
    except ValueError as error:
        raise InvalidInputError(f"{path.name}: not JSON: {error}") from None


def read_object(path: Path) -> dict[str, Any]:
    """Return the object in a JSON file; `InvalidInputError` if it holds anything else."""
    content = read_json(path)
    if not isinstance(content, dict):
        raise InvalidInputError(f"{path.name}: a JSON object is needed, this is {type(content).__name__}")
    return content
