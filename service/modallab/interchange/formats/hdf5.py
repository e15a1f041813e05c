"""HDF5 files, MATLAB files from version 7.3 on among them."""

from modallab.interchange.file_content import FileContent, Piece
from modallab.interchange.format import FRF_FORMATS, FrfFormat
from modallab.interchange.reading_options import ReadingOptions
from modallab.interchange.variables import content_of

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_MATLAB = b"MATLAB 7.3 MAT-file"  # 512 bytes before the signature


def _read(piece: Piece, options: ReadingOptions, largest: int) -> FileContent:
    from modallab.interchange.hdf5_arrays import arrays_of

    return content_of(arrays_of(piece.content, largest), options)


FRF_FORMATS.register("hdf5")(
    FrfFormat("HDF5, or MATLAB 7.3 (.mat)", lambda head: head.startswith((_SIGNATURE, _MATLAB)), _read)
)
