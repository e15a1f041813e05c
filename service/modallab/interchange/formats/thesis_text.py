"""Text of the program that comes with the thesis (`.FRF`)."""

from modallab.interchange import frf_text
from modallab.interchange.file_content import FileContent, Piece
from modallab.interchange.format import FRF_FORMATS, FrfFormat
from modallab.interchange.reading_options import ReadingOptions


def _read(piece: Piece, _: ReadingOptions, largest: int) -> FileContent:
    return frf_text.read(piece.content, largest=largest)


FRF_FORMATS.register("thesis_text")(FrfFormat("FRF text", frf_text.starts, _read))
