"""Archives (zip): arrays of numpy (npz), or the files of one test."""

import io
import zipfile
from pathlib import PurePosixPath

from modallab.core.errors import InvalidInputError, JsonValue, bounds
from modallab.interchange import npz
from modallab.interchange.file_content import FileContent, Piece
from modallab.interchange.format import FRF_FORMATS, FrfFormat, joined
from modallab.interchange.reading_options import ReadingOptions
from modallab.interchange.settings import READING

_MAGIC = b"PK"
_FAULTS = (zipfile.BadZipFile, zipfile.LargeZipFile, NotImplementedError, RuntimeError, EOFError, OSError)


def _read(piece: Piece, options: ReadingOptions, largest: int) -> FileContent:
    """Return the arrays of a npz file, or the FRFs of all files in an archive."""
    try:
        with zipfile.ZipFile(io.BytesIO(piece.content)) as archive:
            members = [info for info in archive.infolist() if _is_data(info)]
            if all(info.filename.endswith(".npy") for info in members):
                return npz.read(piece.content, largest=largest, options=options)
            return joined(_pieces(archive, members, largest), options, largest)
    except _FAULTS as error:
        raise _refusal(f"the archive is damaged: {error}") from None
    except Exception as error:  # decompressors raise a dozen kinds at hostile bytes
        if isinstance(error, (InvalidInputError, MemoryError)):
            raise
        raise _refusal(f"the archive is damaged: {error}") from None


def _is_data(info: zipfile.ZipInfo) -> bool:
    """Return whether a member is a file that somebody put there."""
    path = PurePosixPath(info.filename)
    hidden = any(part.startswith((".", "__MACOSX")) for part in path.parts)
    return not info.is_dir() and not hidden


def _pieces(archive: zipfile.ZipFile, members: list[zipfile.ZipInfo], largest: int) -> list[Piece]:
    total = sum(info.file_size for info in members)
    if total > largest:
        raise _refusal("the files are too large when unpacked", value=total, allowed=bounds(maximum=largest))
    if len(members) > READING.max_files:
        raise _refusal("the archive has too many files", value=len(members), allowed=READING.max_files)
    pieces = []
    for number, info in enumerate(sorted(members, key=lambda info: info.filename), 1):
        with archive.open(info) as member:
            content = member.read(info.file_size)
        if content.startswith(_MAGIC) and not info.filename.endswith(".npz"):
            raise _refusal(f"{info.filename[:60]} is an archive within the archive")
        pieces.append(Piece(PurePosixPath(info.filename).name, content, number))
    return pieces


def _refusal(message: str, **context: JsonValue) -> InvalidInputError:
    return InvalidInputError(message, **({"field": "file", "allowed": "npz, or a zip of files"} | context))


FRF_FORMATS.register("archive")(
    FrfFormat("npz, or a zip of several files", lambda head: head.startswith(_MAGIC), _read)
)
