"""Measurements and modal models from files of unknown origin; their content determines the format."""

from collections.abc import Sequence
from typing import BinaryIO

from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel
from modallab.interchange import uff
from modallab.interchange.confinement import Content, NamedFile, read_confined
from modallab.interchange.declared import NOTHING_DECLARED, DeclaredTest
from modallab.interchange.file_content import fields_from
from modallab.interchange.measured import MeasuredFile
from modallab.interchange.mode_parts import modes_from
from modallab.interchange.reading_options import NO_OPTIONS, ReadingOptions
from modallab.interchange.settings import UNIVERSAL
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup


def read_measurement(
    files: BinaryIO | Sequence[NamedFile],
    setup: RigSetup | None,
    *,
    largest: int,
    options: ReadingOptions = NO_OPTIONS,
    declared: DeclaredTest = NOTHING_DECLARED,
) -> Measurement:
    """Return the measurement of one or more files of any format of `FRF_FORMATS`.

    Parameters
    ----------
    files
        The file, or the files of the test with their names.
    setup
        The log book of the test; responses that the file lacks are dropped from it. None where there is
        none: the rig is then what the file itself tells, and what is declared.
    largest
        Bytes that the files together, and their arrays, may take.
    options
        What the files do not say, or say in their own words.
    declared
        What is known of the test beside its files.

    Raises
    ------
    InvalidInputError
        If a file is of no format, is damaged, holds NaN, or contradicts the rig.
    """
    named = files if isinstance(files, Sequence) else (NamedFile("", files),)
    measured_file = MeasuredFile(**fields_from(*read_confined(named, options, largest=largest)))
    return measured_file.on_rig(setup, declared) if setup else measured_file.without_log_book(declared)


def read_modal_model(file: BinaryIO, *, largest: int) -> ModalModel:
    """Return the modes of a universal file (dataset 55).

    Parameters
    ----------
    file
        The file; no more of it is read than its format may take.
    largest
        Bytes it may have.

    Raises
    ------
    InvalidInputError
        If it is no universal file, is damaged, holds no modes, or takes too much memory or time.
    """
    limit = min(largest, UNIVERSAL.max_bytes)
    parts = read_confined(
        (NamedFile("", file),), NO_OPTIONS, largest=limit, content=Content.MODES, check=_check_universal
    )
    return modes_from(*parts)


def _check_universal(head: bytes) -> None:
    if not uff.starts(head):
        raise InvalidInputError("the file is no universal file", field="file", allowed="universal file (55)")
