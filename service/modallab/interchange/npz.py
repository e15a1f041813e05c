"""Measurements from npz files of unknown origin: every array is checked."""

from modallab.interchange.file_content import FileContent
from modallab.interchange.npz_arrays import load
from modallab.interchange.reading_options import NO_OPTIONS, ReadingOptions
from modallab.interchange.variables import content_of


def read(payload: bytes, *, largest: int, options: ReadingOptions = NO_OPTIONS) -> FileContent:
    """Return the measured FRFs of a npz file.

    Parameters
    ----------
    payload
        The file: `freq, values, outputs, inputs, kind`, and optionally `coherence, averages,
        force_spectrum, response_spectrum, force_cross_spectra`; or arrays of other names.
    largest
        Bytes that the arrays may take when unpacked.
    options
        Roles of arrays that have other names, and what the file does not say.

    Raises
    ------
    InvalidInputError
        If it is no such file, its arrays do not fit together, or hold NaN.
    """
    return content_of(load(payload, None, largest), options)
