"""Measurements and modal models from files of unknown origin; their content determines the format."""

from typing import BinaryIO

from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel
from modallab.interchange import frf_text, hdf5, npz, uff, uff_modes
from modallab.interchange.measured import MeasuredFile
from modallab.interchange.settings import FRF_TEXT_FILE, READING, UNIVERSAL
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup

_ZIP = b"PK"


def read_measurement(
    file: BinaryIO, setup: RigSetup | None, *, largest: int, averages: float | None = None
) -> Measurement:
    """Return the measurement of a universal file (dataset 58), npz, HDF5 or `.FRF` file.

    Parameters
    ----------
    file
        The file; no more of it is read than its format may take.
    setup
        The log book of the test; responses that the file lacks are dropped from it. None where there is
        none: the rig is then what the file itself tells.
    largest
        Bytes that the file's arrays may take.
    averages
        Effective averages; by default the file's, or else the rig's.

    Raises
    ------
    InvalidInputError
        If the file is none of these, is damaged, holds NaN, or contradicts the rig.
    """
    measured_file = _measured(file, largest)
    return (
        measured_file.without_log_book(averages) if setup is None else measured_file.on_rig(setup, averages)
    )


def _measured(file: BinaryIO, largest: int) -> MeasuredFile:
    """Return the measured FRFs of a file; its first bytes determine the format."""
    head = file.read(READING.head_bytes)
    if head.startswith(_ZIP):
        return npz.read(head + file.read(), largest=largest)
    if uff.starts(head):
        limit = min(largest, UNIVERSAL.max_bytes)
        return uff.read(head + file.read(limit), largest=limit)
    if head.startswith(hdf5.SIGNATURE):
        file.seek(0)
        return hdf5.read(file, largest=largest)
    if frf_text.starts(head):
        limit = min(largest, FRF_TEXT_FILE.max_bytes)
        return frf_text.read(head + file.read(limit), largest=limit)
    raise InvalidInputError(
        "the file is neither a universal file nor npz, HDF5 or FRF text",
        field="file",
        allowed=["universal file (58)", "npz", "HDF5", "FRF text"],
    )


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
        If it is no universal file, is damaged, or holds no modes.
    """
    head = file.read(READING.head_bytes)
    if not uff.starts(head):
        raise InvalidInputError("the file is no universal file", field="file", allowed="universal file (55)")
    limit = min(largest, UNIVERSAL.max_bytes)
    return uff_modes.read(head + file.read(limit), largest=limit)
