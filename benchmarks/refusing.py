"""Seconds in which a file that is wrong, however large, is refused, against the limit of its reader."""

import io
import time
from collections.abc import Callable, Iterable
from functools import partial
from itertools import islice

from benchmarks.bench import Bench
from modallab.core.errors import InvalidInputError
from modallab.interchange import reading
from tests.rigs import rig
from tests.service.interchange import test_frf_text, test_hdf5, test_uff, test_uff_modes

LIMIT = 2.0  # s of processor time
LIMIT_HDF5 = 10.0  # s on the clock: another process reads it


def run(n_files: int | None = None) -> list[tuple[str, float, float]]:
    """Return (name, time of the slowest refusal over its limit, 1) of every reader, for some or all files."""
    beam = rig(5, analyser={"frequency_max": 22.0, "n_lines": 12})
    single = rig(1, analyser={"frequency_max": 100.0, "n_lines": 21})
    setup, cpu = test_uff.measured().setup, time.process_time

    def hdf5(payload: bytes) -> object:
        return reading.read_measurement(io.BytesIO(payload), single, largest=test_hdf5.LIMIT)

    universal = [*test_uff.HOSTILE.values(), *test_uff.LATE.values()]
    texts = [text.encode("latin-1") for text in test_frf_text.HOSTILE.values()]
    slowest = partial(_slowest, n_files=n_files)
    shares = {
        "universal file": slowest(lambda p: test_uff.taken(p, setup), universal, cpu) / LIMIT,
        "file of modes": slowest(test_uff_modes.read, test_uff_modes.HOSTILE.values(), cpu) / LIMIT,
        "FRF text": slowest(lambda p: test_frf_text.taken(p, beam), texts, cpu) / LIMIT,
        "HDF5": slowest(hdf5, test_hdf5.HOSTILE.values(), time.monotonic) / LIMIT_HDF5,
    }
    return [
        (f"slowest refusal of a hostile {name}, of its limit", share, 1.0) for name, share in shares.items()
    ]


def _slowest(
    read: Callable[[bytes], object],
    payloads: Iterable[bytes],
    clock: Callable[[], float],
    n_files: int | None,
) -> float:
    slowest = 0.0
    for payload in islice(payloads, n_files):
        begun = clock()
        try:
            read(payload)
        except InvalidInputError:
            slowest = max(slowest, clock() - begun)
        else:
            raise AssertionError("a hostile file was taken")
    return slowest


BENCH = Bench(run, short=partial(run, n_files=1))
