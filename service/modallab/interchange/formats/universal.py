"""Universal files, dataset 58."""

import re

from modallab.interchange.file_content import FileContent, Piece
from modallab.interchange.format import FRF_FORMATS, FrfFormat
from modallab.interchange.reading_options import ReadingOptions

_FIRST = re.compile(rb"\s*-1")


def _read(piece: Piece, options: ReadingOptions, largest: int) -> FileContent:
    from modallab.interchange import uff

    return uff.read(piece.content, largest=largest, options=options)


FRF_FORMATS.register("universal_file")(
    FrfFormat("universal file (58)", lambda head: _FIRST.match(head) is not None, _read)
)
