"""Measurements from files, read in this process: for tests with many files."""

from typing import Any

from modallab.interchange.declared import DeclaredTest
from modallab.interchange.file_content import FileContent, Piece, fields_from
from modallab.interchange.format import read_pieces
from modallab.interchange.measured import MeasuredFile
from modallab.interchange.reading_options import ReadingOptions
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup

LARGEST = 200_000_000


def content_here(*contents: bytes, largest: int = LARGEST, **options: Any) -> FileContent:
    """Return what the files of one test hold."""
    pieces = [Piece(f"{number}.txt", content, number) for number, content in enumerate(contents, 1)]
    return read_pieces(pieces, ReadingOptions(**options), largest=largest)


def read_here(
    payload: bytes, setup: RigSetup | None, *, averages: float | None = None, largest: int = LARGEST
) -> Measurement:
    """Return the measurement of a file."""
    content = content_here(payload, largest=largest)
    measured_file = MeasuredFile(**fields_from(content.as_json(), content.as_arrays()))
    declared = DeclaredTest(averages)
    return measured_file.on_rig(setup, declared) if setup else measured_file.without_log_book(declared)
