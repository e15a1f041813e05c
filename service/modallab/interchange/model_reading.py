"""Models from files of unknown origin: their content says what they are."""

import io
import zipfile
from typing import BinaryIO

from modallab.core.errors import InvalidInputError
from modallab.fe.damping import Damping
from modallab.fe.structure import Structure
from modallab.interchange import model_archive, model_npz
from modallab.interchange.nastran import deck
from modallab.interchange.nastran import model as nastran

_ZIP = b"PK"
_HEAD = 4_096  # bytes that tell what a file is
_ALLOWED = "Nastran bulk data, npz of matrices, zip of Matrix Market or OUTPUT4 files with dofs.txt"


def read_model(file: BinaryIO, *, largest: int, damping: Damping | None = None, name: str = "") -> Structure:
    """Return the structure of a bulk data file, or of a npz file or archive of matrices.

    Parameters
    ----------
    file
        The file; no more of it is read than its format may take.
    largest
        Bytes that the file, or its arrays, may take.
    damping
        Of the structure; by default none but what the file's elements have.

    Raises
    ------
    InvalidInputError
        If the file is none of these, is damaged, or holds no structure that can be analysed.
    """
    head = file.read(_HEAD)
    if head.startswith(_ZIP):
        payload = head + file.read(largest)
        names = _names(payload)
        if any(one.endswith(model_archive.ENDINGS) for one in names):
            return model_archive.read(payload, largest=largest, damping=damping, name=name)
        if model_npz.holds_model(frozenset(one.removesuffix(".npy") for one in names)):
            return model_npz.read(payload, largest=largest, damping=damping, name=name)
    elif deck.starts(head):
        payload = head + file.read(min(largest, deck.LARGEST))
        return nastran.read(payload, damping=damping, name=name)
    raise InvalidInputError("the file holds no model", field="file", allowed=_ALLOWED)


def _names(payload: bytes) -> list[str]:
    try:
        with zipfile.ZipFile(io.BytesIO(payload)) as archive:
            return archive.namelist()
    # Any: the parser of archives raises a dozen kinds at hostile bytes.
    except Exception as error:
        raise InvalidInputError(f"not a zip archive: {error}", field="file", allowed=_ALLOWED) from None
