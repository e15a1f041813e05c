"""Separate program that reads the files of a test in a folder, and writes their FRFs to standard output.

Exit code 3, with the reason as JSON in the last line of standard error: the files are refused. Any other
code than 0: a parser failed.
"""

import io
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from modallab.core.errors import InvalidInputError
from modallab.interchange.confinement import REFUSED, REQUEST
from modallab.interchange.file_content import FileContent, Piece
from modallab.interchange.format import read_pieces
from modallab.interchange.reading_options import options_from_json


def main(folder: str) -> None:
    """Write the FRFs of the files in a folder to standard output."""
    request = json.loads((Path(folder) / REQUEST).read_text())
    tempfile.tempdir = folder  # removed by the caller, whatever becomes of this process
    _confine(request)
    try:
        content = _content(Path(folder), request)
    except InvalidInputError as error:
        _refuse(str(error), error.context)
    except MemoryError:
        _refuse("the file is larger inside than outside", {"field": "file"})
    _write(content)


def _content(folder: Path, request: dict[str, Any]) -> FileContent:
    pieces = [
        Piece(name, (folder / str(index)).read_bytes(), index + 1)
        for index, name in enumerate(request["names"])
    ]
    return read_pieces(pieces, options_from_json(request["options"]), largest=request["largest"])


def _write(content: FileContent) -> None:
    buffer = io.BytesIO()
    about = np.array(json.dumps(content.as_json()))
    np.savez(buffer, allow_pickle=False, about=about, **content.as_arrays())
    sys.stdout.buffer.write(buffer.getbuffer())
    sys.stdout.buffer.flush()


def _refuse(message: str, context: dict[str, Any]) -> None:
    sys.stderr.write(json.dumps({"message": message, "context": context}) + "\n")
    raise SystemExit(REFUSED)


def _confine(request: dict[str, Any]) -> None:
    """Limit memory and time, where the system supports it."""
    try:
        import resource
    except ImportError:  # not on Windows
        return
    seconds, memory, written = (request[name] for name in ("processor_seconds", "memory_bytes", "file_bytes"))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    resource.setrlimit(resource.RLIMIT_FSIZE, (written, written))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


if __name__ == "__main__":
    main(sys.argv[1])
