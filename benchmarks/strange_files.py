"""Files of FRFs as other programs write them, read and compared, and damaged ones, refused.

Not part of `make bench`: it prints counts, not ratios.

python -m benchmarks.strange_files     # all files, 200 damaged, 200 with bits flipped: counts, times, memory
"""

import os
import resource
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO

import numpy as np

from benchmarks.bench import parser
from benchmarks.strange_cases import Case, damaged_cases, flipped_cases, strange_cases
from modallab.core.errors import InvalidInputError
from modallab.interchange.confinement import NamedFile
from modallab.interchange.reading import read_measurement
from modallab.interchange.reading_options import ReadingOptions
from modallab.rig.measurement import Measurement

LARGEST = 200_000_000
SAME = 1e-6  # error of FRFs over their largest magnitude
SLOW = 2.0  # s of a processor
LARGE = 500.0  # MB


def spent() -> float:
    """Return the processor time, s, of this process and of those that have read for it."""
    return sum(os.times()[:4])


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
        begun = spent()
        try:
            measurement = read_case(case)
        except InvalidInputError as problem:
            print(f"{case.name:<58} REFUSED: {problem}", flush=True)
            continue
        error = error_of(case, measurement)
        n_read += error <= SAME
        seconds, assumed = spent() - begun, ", ".join(a.quantity for a in measurement.assumed)
        mark = "" if error <= SAME else "  WRONG"
        print(f"{case.name:<58} {error:8.1e} {seconds:5.2f} s  assumed: {assumed}{mark}", flush=True)
    return n_read


@dataclass(frozen=True)
class Outcome:
    """What became of damaged files."""

    named: int
    """Number of problems that name a field."""
    read: int
    """Number of files that were read all the same, as they may be."""
    unnamed: int
    """Number of problems without a field, of failures of another kind, and of files wrongly read."""
    slowest: float
    """Longest processor time of a file, s."""


def report_damaged(cases: Sequence[Case], *, readable: bool) -> Outcome:
    """Print what is not as it should be, and return what became of the files.

    Parameters
    ----------
    readable
        Whether a file may be read all the same, if all its numbers are finite.
    """
    named = read = unnamed = 0
    slowest = 0.0
    for case in cases:
        begun = spent()
        try:
            measurement = read_case(case)
        except InvalidInputError as error:
            fully = bool(error.context.get("field")) and bool(str(error))
            named, unnamed = named + fully, unnamed + (not fully)
            if not fully:
                print(f"{case.name}: no field: {error}", flush=True)
        except Exception as error:  # a failure that no caller expects is what this looks for
            unnamed += 1
            print(f"{case.name}: {type(error).__name__}: {error}", flush=True)
        else:
            sound = readable and bool(np.isfinite(measurement.frf.values).all())
            read, unnamed = read + sound, unnamed + (not sound)
            if not sound:
                print(f"{case.name}: TAKEN", flush=True)
        seconds = spent() - begun
        if seconds > SLOW:
            print(f"{case.name}: {seconds:.1f} s", flush=True)
        slowest = max(slowest, seconds)
    return Outcome(named, read, unnamed, slowest)


def peak_memory() -> tuple[float, float]:
    """Return the most memory, MB, that this process and any of those that read for it held."""
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    parent, children = (resource.getrusage(kind).ru_maxrss / 1e3 for kind in kinds)
    return parent, children


def main() -> bool:
    """Print counts of files read and refused; return whether all is as it should be."""
    arguments = parser(__doc__)
    arguments.add_argument("--every", type=int, default=1, help="read the first of so many files alone")
    every = arguments.parse_args().every
    cases = strange_cases()
    damaged, flipped = damaged_cases(cases)[::every], flipped_cases(cases)[::every]
    cases = cases[::every]
    before = peak_memory()[0]
    n_read = report_strange(cases)
    spoilt, struck = report_damaged(damaged, readable=False), report_damaged(flipped, readable=True)
    parent, children = peak_memory()
    print(f"\nread, equal to {SAME:g}: {n_read} of {len(cases)}")
    print(f"damaged, a named problem: {spoilt.named} of {len(damaged)}, slowest {spoilt.slowest:.2f} s")
    print(
        f"bits flipped, a named problem: {struck.named} of {len(flipped)}, read: {struck.read}, other: "
        f"{struck.unnamed}, slowest {struck.slowest:.2f} s"
    )
    print(
        f"largest process that reads: {children:.0f} MB; the one that asks: {parent:.0f} MB, "
        f"{before:.0f} MB of them before"
    )
    return (
        n_read == len(cases)
        and spoilt.named == len(damaged)
        and struck.named + struck.read == len(flipped)
        and max(spoilt.slowest, struck.slowest) < SLOW
        and max(parent, children) < LARGE
    )


if __name__ == "__main__":
    sys.exit(not main())
