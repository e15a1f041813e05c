"""Measurements as HDF5 files: the names of the npz file, with units; in and out."""

import contextlib
import io
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import BinaryIO

import h5py
import numpy as np

from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind
from modallab.interchange import npz
from modallab.interchange.measured import MeasuredFile
from modallab.interchange.settings import HDF5
from modallab.rig.measurement import Measurement

SIGNATURE = b"\x89HDF\r\n\x1a\n"
_MOTIONS = {FrfKind.RECEPTANCE: "m", FrfKind.MOBILITY: "m/s", FrfKind.INERTANCE: "m/s^2"}


def write(measurement: Measurement) -> bytes:
    """Return a measurement as an HDF5 file; the same measurement gives the same bytes.

    Datasets `freq, values, outputs, inputs, kind, averages`, and where there are such `coherence,
    force_spectrum, response_spectrum`, shaped as in a measurement's npz file. Those of numbers
    have an attribute `unit`, and the file has the measurement's `notes` as one.
    """
    frf, motion = measurement.frf, _MOTIONS[measurement.frf.kind]
    arrays = {
        "freq": (frf.freq, "Hz"),
        "values": (frf.values, f"{motion}/N"),
        "coherence": (measurement.coherence, "1"),
        "averages": (np.float64(measurement.averages), "1"),
        "force_spectrum": (measurement.force_spectrum, "N^2/Hz"),
        "response_spectrum": (measurement.response_spectrum, f"({motion})^2/Hz"),
    }
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        file.attrs["format"] = "modallab measurement 1"
        if measurement.notes:
            file.attrs["notes"] = "\n".join(measurement.notes)
        for name, dofs in (("outputs", frf.outputs), ("inputs", frf.inputs)):
            file.create_dataset(name, data=np.array([str(dof) for dof in dofs], dtype=bytes))
        file.create_dataset("kind", data=np.bytes_(frf.kind.value))
        for name, (array, unit) in arrays.items():
            if array is not None:
                file.create_dataset(name, data=array).attrs["unit"] = unit
    return buffer.getvalue()


def read(file: BinaryIO, *, largest: int) -> MeasuredFile:
    """Return the measured FRFs of an HDF5 file.

    The HDF5 library is not safe against hostile files, so a separate process with limited memory and time
    reads the file; it opens no other file, and its failure harms nothing else.

    Parameters
    ----------
    file
        The file, from its beginning.
    largest
        Bytes that the file and its arrays may have.

    Raises
    ------
    InvalidInputError
        If it is no such file, is damaged, its arrays do not fit together, or hold NaN.
    """
    limit = min(largest, HDF5.max_bytes)
    with tempfile.TemporaryDirectory(prefix="modallab-") as folder:
        path = Path(folder) / "measured.h5"
        with path.open("wb") as copy:
            while chunk := file.read(HDF5.chunk_bytes):
                copy.write(chunk)
                if copy.tell() > limit:
                    raise _refusal(f"the HDF5 file is larger than {limit} bytes")
        return npz.read(_unpacked(path, limit), largest=2 * limit)


def _unpacked(path: Path, limit: int) -> bytes:
    """Return the arrays of an HDF5 file as npz."""
    # Only the filters of the library itself, no locks, no threads.
    settings = {"HDF5_PLUGIN_PRELOAD": "::", "HDF5_USE_FILE_LOCKING": "FALSE", "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-P", "-m", "modallab.interchange.hdf5_reader", str(path), str(limit)]
    try:
        run = subprocess.run(
            command,
            env={**os.environ, **settings},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=HDF5.timeout,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise _refusal("the HDF5 file takes too long to read") from None
    if run.returncode == 0:
        return run.stdout
    reason = "it is damaged, or larger inside than outside"
    if run.returncode == 1:
        with contextlib.suppress(IndexError):
            reason = run.stderr.decode("utf-8", "replace").splitlines()[-1][:200]
    raise _refusal(f"the HDF5 file cannot be read: {reason}")


def _refusal(message: str) -> InvalidInputError:
    return InvalidInputError(message, field="file", allowed="HDF5: freq, values, outputs, inputs, kind")
