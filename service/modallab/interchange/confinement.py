"""Reading of files of unknown origin in a process of its own, with little memory and time.

Parsers, above all those in C, are not safe against hostile files. The process that reads opens no other
file, and its failure harms nothing else.
"""

import contextlib
import io
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import InvalidInputError, bounds
from modallab.interchange.format import format_of
from modallab.interchange.reading_options import ReadingOptions
from modallab.interchange.settings import CONFINEMENT, READING

REQUEST, REFUSED = "request.json", 3
_OUT_OF_TIME = -getattr(signal, "SIGXCPU", 0)  # no such signal on Windows; 0 is success
_TOO_LONG = "the file takes too long to read"
_MODULE = "modallab.interchange.reader_process"
# Only the filters of the HDF5 library itself, no locks; one thread.
_ENVIRONMENT = {
    "HDF5_PLUGIN_PRELOAD": "::",
    "HDF5_USE_FILE_LOCKING": "FALSE",
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
}


class Content(StrEnum):
    """What is read from files."""

    FRFS = "frfs"
    MODES = "modes"


@dataclass(frozen=True)
class NamedFile:
    """A file of a test as it comes in."""

    name: str
    """Name that the sender gave it."""
    file: BinaryIO
    """The file, from its beginning."""


def read_confined(
    files: Sequence[NamedFile],
    options: ReadingOptions,
    *,
    largest: int,
    content: Content = Content.FRFS,
    check: Callable[[bytes], object] = format_of,
) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return the content of files, read by another process, as JSON and as arrays by name.

    Parameters
    ----------
    files
        The files.
    options
        What the files do not say.
    largest
        Bytes that the files together, and their arrays, may have.
    content
        What is read from them.
    check
        Refuses the first bytes of a file of no format with this content: it costs no process.

    Raises
    ------
    InvalidInputError
        If the files are refused, or cost too much memory or time.
    """
    request = {
        "content": content,
        "names": [named.name for named in files],
        "options": options.as_json(),
    }
    return run_confined(_MODULE, files, request, largest=largest, check=check)


def run_confined(
    module: str,
    files: Sequence[NamedFile],
    request: Mapping[str, Any],
    *,
    largest: int,
    check: Callable[[bytes], object] | None = None,
) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return what a program says of files, as JSON and as arrays by name.

    Parameters
    ----------
    module
        The program: it calls `reader_process.answer`.
    request
        What it is asked beside the files, as JSON.
    files, largest, check
        As in `read_confined`.

    Raises
    ------
    InvalidInputError
        As `read_confined`.
    """
    limit = min(largest, CONFINEMENT.max_bytes)
    with tempfile.TemporaryDirectory(prefix="modallab-") as folder:
        total = _copy(files, Path(folder), limit, check)
        seconds = CONFINEMENT.processor_seconds + int(total / CONFINEMENT.bytes_per_second)
        limits = {
            "largest": limit,
            "memory_bytes": CONFINEMENT.memory_bytes + CONFINEMENT.memory_per_byte * total,
            "processor_seconds": seconds,
            "file_bytes": 2 * total + CONFINEMENT.chunk_bytes,
        }
        (Path(folder) / REQUEST).write_text(json.dumps({**request, **limits}))
        output = _output(module, folder, seconds + CONFINEMENT.patience)
    with np.load(io.BytesIO(output), allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    about: dict[str, Any] = json.loads(str(arrays.pop("about")))
    return about, arrays


def _copy(
    files: Sequence[NamedFile], folder: Path, limit: int, check: Callable[[bytes], object] | None
) -> int:
    """Copy files of known formats into a folder, under their numbers; return their bytes."""
    total = 0
    for number, named in enumerate(files):
        with (folder / str(number)).open("wb") as copy:
            head = named.file.read(READING.head_bytes)
            if check is not None:
                check(head)
            named.file.seek(0)
            while chunk := named.file.read(CONFINEMENT.chunk_bytes):
                total += len(chunk)
                if total > limit:
                    raise InvalidInputError(
                        f"the file is larger than {limit / 1e6:g} MB; what belongs to neither FRFs nor "
                        "modes, such as time records, may be left out of it",
                        field="file",
                        allowed=bounds(maximum=limit, unit="bytes"),
                    )
                copy.write(chunk)
    return total


def _output(module: str, folder: str, timeout: float) -> bytes:
    """Return what a program writes about the files in a folder."""
    try:
        run = subprocess.run(
            [sys.executable, "-P", "-m", module, folder],
            env={**os.environ, **_ENVIRONMENT},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=timeout,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise InvalidInputError(_TOO_LONG, field="file") from None
    if run.returncode == 0:
        return run.stdout
    if run.returncode == _OUT_OF_TIME:
        raise InvalidInputError(_TOO_LONG, field="file")
    refused = None
    if run.returncode == REFUSED:
        with contextlib.suppress(ValueError, IndexError):
            refused = json.loads(run.stderr.splitlines()[-1])
    if refused is None:
        message = "the file cannot be read: it is damaged, or larger inside than outside"
        raise InvalidInputError(message, field="file")
    raise InvalidInputError(refused["message"], **refused["context"])
