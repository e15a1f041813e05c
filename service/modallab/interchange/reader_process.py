"""Separate program that reads the files in a folder, and writes their FRFs or modes to standard output.

Exit code 3, with the reason as JSON in the last line of standard error: the files are refused. Any other
code than 0: a parser failed.
"""

import io
import json
import math
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from modallab.core.errors import InvalidInputError
from modallab.interchange import uff_modes
from modallab.interchange.confinement import REFUSED, REQUEST, Content
from modallab.interchange.file_content import Piece
from modallab.interchange.format import read_pieces
from modallab.interchange.mode_parts import mode_parts
from modallab.interchange.reading_options import options_from_json

Parts = tuple[dict[str, Any], dict[str, Any]]


def main(folder: str) -> None:
    """Write the FRFs or modes of the files in a folder to standard output."""
    answer(folder, lambda path, request: _READERS[request["content"]](path, request))


def answer(folder: str, read: Callable[[Path, dict[str, Any]], Parts]) -> None:
    """Write what a function reads from the files in a folder to standard output, within the limits.

    Parameters
    ----------
    folder
        Folder of the files, by their numbers, and of the request.
    read
        Function of folder and request; it returns JSON and arrays by name.
    """
    request = json.loads((Path(folder) / REQUEST).read_text())
    tempfile.tempdir = folder  # removed by the caller, whatever becomes of this process
    _confine(request)
    try:
        about, arrays = read(Path(folder), request)
    except InvalidInputError as error:
        _refuse(str(error), error.context)
    except MemoryError:
        _refuse("the file is larger inside than outside", {"field": "file"})
    _write(about, arrays)


def _frfs(folder: Path, request: dict[str, Any]) -> Parts:
    pieces = [
        Piece(name, (folder / str(index)).read_bytes(), index + 1)
        for index, name in enumerate(request["names"])
    ]
    content = read_pieces(pieces, options_from_json(request["options"]), largest=request["largest"])
    return content.as_json(), content.as_arrays()


def _modes(folder: Path, request: dict[str, Any]) -> Parts:
    return mode_parts(uff_modes.read((folder / "0").read_bytes(), largest=request["largest"]))


_READERS: dict[str, Callable[[Path, dict[str, Any]], Parts]] = {
    Content.FRFS: _frfs,
    Content.MODES: _modes,
}


def _write(about: dict[str, Any], arrays: dict[str, Any]) -> None:
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, about=np.array(json.dumps(about)), **arrays)
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
    # The imports of this program are no fault of the file: a slow machine needs seconds for them.
    end = math.ceil(time.process_time()) + seconds
    resource.setrlimit(resource.RLIMIT_CPU, (end, end + 1))
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    resource.setrlimit(resource.RLIMIT_FSIZE, (written, written))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


if __name__ == "__main__":
    main(sys.argv[1])
