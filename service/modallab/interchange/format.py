"""Formats of measured FRFs: a family whose members recognise and read one format each."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from modallab.core.errors import InvalidInputError
from modallab.core.registry import Family
from modallab.interchange.file_content import FileContent, Piece, merged
from modallab.interchange.reading_options import ReadingOptions
from modallab.interchange.settings import READING


@dataclass(frozen=True)
class FrfFormat:
    """A format of files with FRFs."""

    summary: str
    """Name and extensions, for a refusal."""
    starts: Callable[[bytes], bool]
    """Whether a file with these first bytes is of this format."""
    read: Callable[[Piece, ReadingOptions, int], FileContent]
    """Content of a file, from at most so many bytes of arrays."""
    last: bool = False
    """Whether other formats are tried first."""


FRF_FORMATS: Family[FrfFormat] = Family("format", "modallab.interchange.formats")


def format_of(head: bytes) -> FrfFormat:
    """Return the format of a file by its first bytes.

    Raises
    ------
    InvalidInputError
        If it is none.
    """
    formats = sorted(FRF_FORMATS.values(), key=lambda member: member.last)
    found = next((member for member in formats if member.starts(head)), None)
    if found is None:
        raise InvalidInputError(
            "the file is of no format that holds FRFs",
            field="file",
            allowed=[member.summary for member in formats],
        )
    return found


def read_pieces(pieces: Sequence[Piece], options: ReadingOptions, *, largest: int) -> FileContent:
    """Return the FRFs of the files of one test in SI units.

    Parameters
    ----------
    pieces
        The files.
    options
        What the files do not say.
    largest
        Bytes that the arrays may take.

    Raises
    ------
    InvalidInputError
        If a file is of no format, is damaged, holds NaN, or the files make no test.
    """
    unit = options.frf_unit
    content = joined(pieces, options, largest)
    return content.scaled(*options.factors, None if unit is None else unit.kind).with_tidy_coherence()


def joined(pieces: Sequence[Piece], options: ReadingOptions, largest: int) -> FileContent:
    """Return the FRFs of several files as one, in the units of the files."""
    if not pieces:
        raise InvalidInputError("there is no file with FRFs", field="file", allowed="one file or more")
    return merged([_content(piece, options, largest, of=len(pieces)) for piece in pieces])


def _content(piece: Piece, options: ReadingOptions, largest: int, of: int) -> FileContent:
    try:
        return format_of(piece.content[: READING.head_bytes]).read(piece, options, largest)
    except InvalidInputError as error:
        if of == 1:
            raise
        raise type(error)(f"{piece.name[:60]}: {error}", **error.context) from None
