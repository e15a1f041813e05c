"""Models from files of unknown origin; their content determines the format."""

import io
import zipfile
from typing import BinaryIO

from modallab.core.errors import InvalidInputError
from modallab.fe.damping import Damping
from modallab.fe.structure import Structure
from modallab.interchange import model_archive, model_npz
from modallab.interchange.mesh import reading as mesh
from modallab.interchange.mesh.description import MeshDescription
from modallab.interchange.mesh.structure import structure_of_mesh
from modallab.interchange.nastran import deck
from modallab.interchange.nastran import model as nastran
from modallab.interchange.settings import MODEL_FILE, READING

_ZIP = b"PK"
_FORMATS = (
    "Nastran bulk data, a mesh of gmsh, Abaqus, VTK or Medit, npz of matrices, "
    "zip of Matrix Market or OUTPUT4 files with dofs.txt"
)


def read_model(
    file: BinaryIO,
    *,
    largest: int,
    damping: Damping | None = None,
    name: str = "",
    description: MeshDescription | None = None,
) -> Structure:
    """Return the structure of a bulk data file or a mesh, or of a npz file or archive of matrices.

    Parameters
    ----------
    file
        The file; no more of it is read than its format may take.
    largest
        Bytes that the file, or its arrays, may take.
    damping
        Of the structure; by default none but what the file's elements have.
    description
        What the groups of a mesh are made of; of a mesh only, which needs it.

    Raises
    ------
    InvalidInputError
        If the file is none of these, is damaged, or holds no structure that can be analysed.
    """
    head = file.read(READING.model_head_bytes)
    if mesh.starts(head):
        mesh_file = mesh.read_mesh(head + file.read(min(largest, MODEL_FILE.max_mesh_bytes)))
        return structure_of_mesh(mesh_file, description, damping=damping, name=name)
    if description is not None:
        raise InvalidInputError(
            "the file holds no mesh that `mesh` could describe",
            field="mesh",
            allowed="left out, of other files",
        )
    if head.startswith(_ZIP):
        payload = head + file.read(largest)
        names = _names(payload)
        if any(member.endswith(model_archive.ENDINGS) for member in names):
            return model_archive.read(payload, largest=largest, damping=damping, name=name)
        if model_npz.holds_model(frozenset(member.removesuffix(".npy") for member in names)):
            return model_npz.read(payload, largest=largest, damping=damping, name=name)
    elif deck.starts(head):
        payload = head + file.read(min(largest, MODEL_FILE.max_deck_bytes))
        return nastran.read(payload, damping=damping, name=name)
    raise InvalidInputError("the file holds no model", field="file", allowed=_FORMATS)


def _names(payload: bytes) -> list[str]:
    try:
        with zipfile.ZipFile(io.BytesIO(payload)) as archive:
            return archive.namelist()
    # Any: the parser of archives raises a dozen kinds at hostile bytes.
    except Exception as error:
        raise InvalidInputError(f"not a zip archive: {error}", field="file", allowed=_FORMATS) from None
