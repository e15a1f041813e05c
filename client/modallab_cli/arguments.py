"""Arguments and options that several commands have, and files that are written."""

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from modallab_client.errors import InvalidInputError

PICTURES = (".png", ".svg", ".pdf")
FRF_FILES = (".uff", ".unv", ".npz", ".h5", ".hdf5", ".frf")
MODE_FILES = (".uff", ".unv", ".json")

READ = click.Path(exists=True, dir_okay=False, readable=True, path_type=Path)
WRITTEN = click.Path(path_type=Path)

Command = Callable[..., Any]
Decorator = Callable[[Command], Command]

model = click.option(
    "--model",
    required=True,
    type=READ,
    help="The model: .json, a body of POST /v1/structures; Nastran bulk data; a mesh, with --mesh; matrices.",
)
mesh = click.option(
    "--mesh",
    type=READ,
    help="Of a mesh, JSON: sections, thicknesses and materials by group, supports, what is left out.",
)
rig = click.option(
    "--rig", required=True, type=READ, help="The log book of the test: .json, a body of POST /v1/rigs."
)
optional_rig = click.option(
    "--rig", type=READ, help="The log book of the test, as JSON; left out: what the file tells."
)
measured = click.argument("measured", type=READ)
averages = click.option(
    "--averages", type=float, help="Effective averages; default: the file's, or else the rig's."
)
bands = click.option(
    "--bands", "--band", "bands", multiple=True, metavar="LOWER:UPPER", help="Band, Hz; may be repeated."
)
exclude = click.option(
    "--exclude",
    multiple=True,
    metavar="LOWER:UPPER",
    help="Band that is left out, Hz; may be repeated.",
)
picture = click.option(
    "--plot", "picture", type=WRITTEN, help="Write a picture of the result: .png, .svg or .pdf."
)
as_json = click.option("--json", "as_json", is_flag=True, help="Print the whole result as JSON.")
server = click.option(
    "--server",
    metavar="URL",
    help="Address of a lab, http://host:8000, whose key is MODALLAB_KEY; left out: this computer.",
)
lab = click.option(
    "--server",
    required=True,
    metavar="URL",
    help="Address of the lab, http://host:8000, whose key is MODALLAB_KEY.",
)


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
