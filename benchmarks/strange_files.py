"""Files of FRFs as other programs write them, read and compared, and damaged ones, refused.

Not part of `make bench`: it prints counts, not ratios.

python -m benchmarks.strange_files              # all files, 200 damaged ones: counts, errors, times, memory
"""

import resource
import sys
import time
from collections.abc import Sequence
from io import BytesIO

import numpy as np

from benchmarks.bench import parser
from benchmarks.strange_cases import Case, damaged_cases, strange_cases
from modallab.core.errors import InvalidInputError
from modallab.interchange.confinement import NamedFile
from modallab.interchange.reading import read_measurement
from modallab.interchange.reading_options import ReadingOptions
from modallab.rig.measurement import Measurement

LARGEST = 200_000_000
SAME = 1e-6  # error of FRFs over their largest magnitude
SLOW = 2.0  # s
LARGE = 500.0  # MB


def read_case(case: Case) -> Measurement:
    """Return the measurement of a case."""
    files = [NamedFile(name, BytesIO(content)) for name, content in case.files]
    return read_measurement(files, None, largest=LARGEST, options=ReadingOptions(**case.options))


def error_of(case: Case, measurement: Measurement) -> float:
    """Return the largest error of frequencies, FRFs and coherence, relative; infinite where points differ."""
    frf = measurement.frf
    if (tuple(map(str, frf.outputs)), tuple(map(str, frf.inputs))) != (case.outputs, case.inputs):
        return float("inf")
    if frf.values.shape != case.values.shape or (measurement.coherence is None) is not (
        case.coherence is None
    ):
        return float("inf")
    errors = [
        float(np.abs(frf.values - case.values).max() / np.abs(case.values).max()),
        float(np.abs(frf.freq - case.freq).max() / case.freq[-1]),
    ]
    if case.coherence is not None and measurement.coherence is not None:
        errors.append(
            float(np.abs(measurement.coherence.reshape(case.coherence.shape) - case.coherence).max())
        )
    return max(errors)


def report_strange(cases: Sequence[Case]) -> int:
    """Print what became of each file; return how many were read as they were made."""
    n_read = 0
    for case in cases:
        begun = time.perf_counter()
        try:
            measurement = read_case(case)
        except InvalidInputError as problem:
            print(f"{case.name:<58} REFUSED: {problem}", flush=True)
            continue
        error = error_of(case, measurement)
        n_read += error <= SAME
        seconds, assumed = time.perf_counter() - begun, ", ".join(a.quantity for a in measurement.assumed)
        mark = "" if error <= SAME else "  WRONG"
        print(f"{case.name:<58} {error:8.1e} {seconds:5.2f} s  assumed: {assumed}{mark}", flush=True)
    return n_read


def report_damaged(cases: Sequence[Case]) -> tuple[int, float]:
    """Print what was wrongly taken; return the number of named problems, and the longest time, s."""
    n_named, slowest = 0, 0.0
    for case in cases:
        begun = time.perf_counter()
        try:
            read_case(case)
        except InvalidInputError as error:
            n_named += bool(error.context.get("field")) and bool(str(error))
        else:
            print(f"{case.name}: TAKEN", flush=True)
        seconds = time.perf_counter() - begun
        if seconds > SLOW:
            print(f"{case.name}: {seconds:.1f} s", flush=True)
        slowest = max(slowest, seconds)
    return n_named, slowest


def main() -> bool:
    """Print counts of files read and refused; return whether all is as it should be."""
    arguments = parser(__doc__)
    arguments.add_argument("--every", type=int, default=1, help="read the first of so many files alone")
    every = arguments.parse_args().every
    cases = strange_cases()[::every]
    n_read = report_strange(cases)
    damaged = damaged_cases(cases)[::every]
    n_named, slowest = report_damaged(damaged)
    usage = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e3
    print(f"\nread, equal to {SAME:g}: {n_read} of {len(cases)}")
    print(f"damaged, a named problem: {n_named} of {len(damaged)}, slowest {slowest:.2f} s")
    print(f"largest process that reads: {usage:.0f} MB")
    return n_read == len(cases) and n_named == len(damaged) and slowest < SLOW and usage < LARGE


if __name__ == "__main__":
    sys.exit(not main())
