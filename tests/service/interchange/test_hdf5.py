"""HDF5 files: what goes out comes back, what others write is read, what is hostile stays outside."""

import io
import json
import os
import subprocess
import sys
import time
import tracemalloc
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind
from modallab.interchange import hdf5, reading
from modallab.interchange.confinement import REFUSED as REFUSED_CODE
from modallab.interchange.confinement import REQUEST, Content
from modallab.interchange.file_content import FileContent
from modallab.interchange.reading_options import NO_OPTIONS
from modallab.interchange.settings import CONFINEMENT
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from tests.reading import content_here
from tests.rigs import dofs, rig, steel_beam
from tests.service.interchange.test_uff import DRIVE, OUTPUTS, measured

LIMIT = 200_000_000
UNITS = {FrfKind.RECEPTANCE: "m", FrfKind.MOBILITY: "m/s", FrfKind.INERTANCE: "m/s^2"}


SIGNATURE = b"\x89HDF\r\n\x1a\n"


def read(payload: bytes) -> FileContent:
    """Return what a file holds."""
    return content_here(payload)


@pytest.mark.parametrize("kind", list(FrfKind))
def test_what_is_written_is_read_with_equal_arrays(kind: FrfKind) -> None:
    given = measured(kind)
    back = read(hdf5.write(given))
    assert (back.frf.outputs, back.frf.inputs, back.frf.kind) == (OUTPUTS, (DRIVE,), kind)
    assert (back.averages, back.notes) == (100.0, ())
    np.testing.assert_array_equal(back.frf.freq, given.frf.freq)
    np.testing.assert_array_equal(back.frf.values, given.frf.values)
    for name in ("coherence", "force_spectrum", "response_spectrum"):
        np.testing.assert_array_equal(getattr(back, name), getattr(given, name), err_msg=name)


@pytest.mark.parametrize("kind", list(FrfKind))
def test_h5py_finds_the_names_of_the_npz_file_with_units(kind: FrfKind) -> None:
    given = measured(kind)
    with h5py.File(io.BytesIO(hdf5.write(given)), "r") as file:
        units = {name: dataset.attrs.get("unit") for name, dataset in file.items()}
        motion = UNITS[kind]
        assert units == {
            "freq": "Hz",
            "values": f"{motion}/N",
            "outputs": None,
            "inputs": None,
            "kind": None,
            "coherence": "1",
            "averages": "1",
            "force_spectrum": "N^2/Hz",
            "response_spectrum": f"({motion})^2/Hz",
        }
        np.testing.assert_array_equal(file["values"][()], given.frf.values)
        assert file["outputs"].asstr()[()].tolist() == [str(dof) for dof in OUTPUTS]
        assert file["kind"].asstr()[()] == kind.value


def test_the_same_measurement_gives_the_same_bytes() -> None:
    first = hdf5.write(measured())
    time.sleep(1.1)  # the format could hold times, in seconds
    assert hdf5.write(measured()) == first


def test_several_drives_keep_a_coherence_for_each_frf_of_a_roving_hammer() -> None:
    drives = (Dof(1, "Y"), Dof(5, "Y"))
    setup = replace(rig(1, 9, analyser={"frequency_max": 64.0, "n_lines": 33}), drives=drives)
    setup = replace(setup, exciter=replace(setup.exciter, kind="hammer"))
    rng = np.random.default_rng(5)
    frf = replace(
        measured().frf,
        values=rng.normal(size=(33, 2, 2)).astype(complex),
        outputs=setup.responses,
        inputs=drives,
    )
    test = Measurement(frf, rng.uniform(size=(33, 2, 2)), 9.0, setup)
    file = io.BytesIO(hdf5.write(test))
    back = reading.read_measurement(file, setup, largest=LIMIT)
    np.testing.assert_array_equal(back.frf.values, frf.values)
    np.testing.assert_array_equal(back.coherence, test.coherence)


def test_cross_spectra_of_simultaneous_forces_come_back() -> None:
    setup = replace(rig(1, 9, analyser={"frequency_max": 64.0, "n_lines": 33}), drives=dofs(1, 9))
    test = measure(steel_beam(), setup, route=Route.DRAWN, rng=np.random.default_rng(3))
    back = reading.read_measurement(io.BytesIO(hdf5.write(test)), setup, largest=LIMIT)
    assert test.force_cross_spectra is not None
    np.testing.assert_array_equal(back.force_cross_spectra, test.force_cross_spectra)
    np.testing.assert_array_equal(back.frf_coherence, test.frf_coherence)


def file_of(**changed: Any) -> bytes:
    """Return what h5py writes of one FRF as others would: strings of any length; None leaves out."""
    arrays: dict[str, Any] = {
        "freq": np.linspace(0.0, 100.0, 21),
        "values": np.ones((21, 1, 1), complex),
        "outputs": ["1:+Y"],
        "inputs": ["1:+Y"],
        "kind": "inertance",
    }
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        for name, content in (arrays | changed).items():
            if callable(content):
                content(file, name)
            elif content is not None:
                file[name] = content
    return buffer.getvalue()


DIALECTS: dict[str, Callable[[Any, str], Any]] = {
    "gzip": lambda f, name: f.create_dataset(name, data=np.ones((21, 1, 1), complex), compression="gzip"),
    "lzf and shuffle": lambda f, name: f.create_dataset(
        name, data=np.ones((21, 1, 1), complex), compression="lzf", shuffle=True
    ),
    "chunks that may grow": lambda f, name: f.create_dataset(
        name, data=np.ones((21, 1, 1), complex), maxshape=(None, 1, 1)
    ),
    "single precision, big-endian": lambda f, name: f.create_dataset(
        name, data=np.ones((21, 1, 1), ">c8"), fletcher32=True
    ),
    "real numbers": lambda f, name: f.create_dataset(name, data=np.ones((21, 1, 1))),
}


@pytest.mark.parametrize("dialect", DIALECTS)
def test_dialects_are_read(dialect: str) -> None:
    back = read(file_of(values=DIALECTS[dialect], strange=np.ones(3)))
    np.testing.assert_array_equal(back.frf.values, np.ones((21, 1, 1)))


# --- hostile files ---------------------------------------------------------------------------------


def a_gigabyte(file: Any, name: str) -> None:
    file.create_dataset(name, (100, 1000, 1000), "c16", compression="gzip", chunks=(1, 100, 1000))


def a_large_chunk(file: Any, name: str) -> None:
    chunks = {"chunks": (10_000_000, 1, 1), "maxshape": (None, None, None)}
    file.create_dataset(name, (21, 1, 1), "c16", compression="gzip", **chunks)[...] = 1


def a_bomb_in_a_chunk(file: Any, name: str) -> None:
    dataset = file.create_dataset(name, (21, 1, 1), "c16", chunks=(21, 1, 1), compression="gzip")
    packer, n = zlib.compressobj(9), 10_000_000
    first = packer.compress(bytes(n)) + packer.flush(zlib.Z_FULL_FLUSH)  # 2 bytes before it; repeats at will
    adler = (100 * n % 65521 << 16) + 1  # of zeros
    packed = first + 99 * first[2:] + b"\x03\x00" + adler.to_bytes(4, "big")
    dataset.id.write_direct_chunk((0, 0, 0), packed)


def a_string_of_20_megabytes(file: Any, name: str) -> None:
    file.create_dataset(name, (2,), h5py.string_dtype())[0] = "x" * 20_000_000


def an_external_link(file: Any, name: str) -> None:
    file[name] = h5py.ExternalLink("/etc/passwd", "/values")


def a_soft_link(file: Any, name: str) -> None:
    file[name] = h5py.SoftLink("/freq")


def data_in_another_file(file: Any, name: str) -> None:
    file.create_dataset(name, (21, 1, 1), "c16", external=[("/etc/passwd", 0, 336)])


def a_virtual_dataset(file: Any, name: str) -> None:
    layout = h5py.VirtualLayout((21, 1, 1), "c16")
    layout[...] = h5py.VirtualSource("/etc/passwd", "values", (21, 1, 1))
    file.create_virtual_dataset(name, layout)


# What the reader itself sees and says; in this process, for the sake of time.
REFUSED: dict[str, bytes] = {
    "a gigabyte declared": file_of(values=a_gigabyte),
    "a chunk of 160 MB": file_of(values=a_large_chunk),
    "a million chunks": file_of(
        values=lambda f, n: f.create_dataset(n, (10**6, 1, 1), "f8", chunks=(1, 1, 1))
    ),
    "a string of 20 MB": file_of(outputs=a_string_of_20_megabytes),
    "a million strings": file_of(outputs=np.full(10**6, b"1:+Y")),
    "an external link": file_of(values=an_external_link),
    "a soft link": file_of(values=a_soft_link),
    "data in another file": file_of(values=data_in_another_file),
    "a virtual dataset": file_of(values=a_virtual_dataset),
    "objects": file_of(values=lambda f, n: f.create_dataset(n, (21,), h5py.vlen_dtype(float))),
    "references": file_of(values=lambda f, n: f.create_dataset(n, (21,), h5py.ref_dtype)),
    "records": file_of(values=np.zeros(21, [("a", float), ("b", float)])),
    "a group": file_of(values=lambda f, n: f.create_group(n)),
    "nothing in it": file_of(values=h5py.Empty("f8")),
    "a number for a word": file_of(kind=5),
    "words for numbers": file_of(values=["1"]),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_array_of_this_file_is_refused(case: str) -> None:
    with pytest.raises(InvalidInputError):
        content_here(REFUSED[case], largest=CONFINEMENT.max_bytes)


HOSTILE: dict[str, bytes] = {
    "a signature only": SIGNATURE,
    "cut off": file_of()[:3000],
    "a gigabyte declared": REFUSED["a gigabyte declared"],
    "a chunk that unpacks to a gigabyte": file_of(values=a_bomb_in_a_chunk),
    "a string of 20 MB": REFUSED["a string of 20 MB"],
    "an external link": REFUSED["an external link"],
    "an array missing": file_of(values=None),
    "another kind": file_of(kind="stiffness"),
    "NaN": file_of(values=np.full((21, 1, 1), np.nan)),
    "another shape": file_of(values=np.ones((20, 1, 1))),
    "100 MB that begin well": SIGNATURE.ljust(100_000_000),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_a_hostile_file_is_refused_in_little_memory(case: str) -> None:
    setup = rig(1, analyser={"frequency_max": 100.0, "n_lines": 21})
    tracemalloc.start()
    with pytest.raises(InvalidInputError) as caught:
        reading.read_measurement(io.BytesIO(HOSTILE[case]), setup, largest=LIMIT)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 200_000_000
    assert caught.value.context["field"]


def test_a_value_that_is_not_finite_is_refused_with_its_line() -> None:
    values = np.ones((21, 1, 1))
    values[5] = np.nan
    with pytest.raises(InvalidInputError, match=r"values .* at \[5, 0, 0\]"):
        read(file_of(values=values))


_MEASURED = """
import resource, subprocess, sys
command = [sys.executable, "-m", "modallab.interchange.reader_process", *sys.argv[1:]]
run = subprocess.run(command, capture_output=True)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(run.returncode, used.ru_maxrss, used.ru_utime + used.ru_stime)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="memory is measured, and limited, as Linux does")
@pytest.mark.parametrize(
    "case", ["a chunk that unpacks to a gigabyte", "a string of 20 MB", "a gigabyte declared"]
)
def test_the_readers_process_has_little_memory_and_time(case: str, tmp_path: Path) -> None:
    (tmp_path / "0").write_bytes(HOSTILE[case])
    limits = {"memory_bytes": CONFINEMENT.memory_bytes, "processor_seconds": CONFINEMENT.processor_seconds}
    files = {"content": Content.FRFS, "names": [""], "options": NO_OPTIONS.as_json(), "file_bytes": 0}
    request = {**files, **limits, "largest": CONFINEMENT.max_bytes}
    (tmp_path / REQUEST).write_text(json.dumps(request))
    # From a small process: a child inherits the peak of who starts it.
    run = subprocess.run(
        [sys.executable, "-c", _MEASURED, str(tmp_path)],
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    code, kilobytes, seconds = (float(field) for field in run.stdout.split())
    assert code == REFUSED_CODE
    assert kilobytes < 350_000  # 300 MB of data, and the libraries
    assert seconds < 4.0  # its limit: 3 s, and a second to notice


def test_a_file_cut_anywhere_is_refused() -> None:
    whole = hdf5.write(measured())
    for length in np.linspace(8, len(whole) - 1, 6, dtype=int):
        with pytest.raises(InvalidInputError):
            read(whole[:length])


def test_damaged_bytes_are_refused_or_read() -> None:
    whole, rng = bytearray(file_of()), np.random.default_rng(2)
    for _ in range(6):
        noisy = bytearray(whole)
        for at in rng.integers(8, len(whole), 60):
            noisy[at] = int(rng.integers(256))
        try:
            read(bytes(noisy))
        except InvalidInputError as error:
            assert error.context["field"]  # noqa: PT017
