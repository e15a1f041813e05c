"""Memory of sampled measurements: as much for 10,000 averages as for 100.

Each in a process of its own, by the most that it ever held; a process that only imports what is needed
is taken off. `python -m benchmarks.memory [averages]` prints the memory of each.
"""

import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.bench import Bench, count
from benchmarks.measuring import setup
from modallab.core.progress import silent
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.rig.chain import chain
from modallab.rig.sampled import sampled_spectra

FEW, MANY = 100, 10_000
KINDS = ("periodic_random", "random")
LIMIT = 1.25  # what does not repeat is made in stretches, of 25 records for 100 averages and of 32 for 10,000


def peak(kind: str, averages: int) -> int:
    """Return the memory, kB, that a process with such a test in it takes at most."""
    code = f"from benchmarks import memory; memory.measure({kind!r}, {averages})"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return int(run.stdout)


def measure(kind: str, averages: int) -> None:
    """Run a test of one response, and print the most memory, kB, that this process had; 0: only get ready."""
    rig = setup(kind, "hann", max(averages, 1))
    whole = chain(assemble(STRUCTURES["chapter-5-beam"]()), replace(rig, responses=rig.responses[:1]))
    if averages:
        sampled_spectra(whole, np.random.default_rng(0), silent)
    # Not `ru_maxrss`: a child begins with what its parent had.
    peak_memory = re.search(r"VmHWM:\s*(\d+) kB", Path("/proc/self/status").read_text())
    assert peak_memory is not None
    print(peak_memory[1])


def run(many: int = MANY, kinds: Sequence[str] = KINDS) -> list[tuple[str, float, float]]:
    """Return (name, memory of many averages over that of few, limit)."""
    rows = []
    for kind in kinds:
        idle, few, most = (peak(kind, averages) for averages in (0, FEW, many))
        name = f"memory of {many:,} sampled averages against {FEW}, {kind}"
        rows.append((name, (most - idle) / (few - idle), LIMIT))
    return rows


BENCH = Bench(run, short=partial(run, many=2 * FEW, kinds=KINDS[:1]), reads_proc=True)


def main() -> None:
    """Print the memory of few and of many averages."""
    many = count(__doc__, MANY, "averages")
    for kind in KINDS:
        print(kind, [f"{averages}: {peak(kind, averages) / 1e3:.1f} MB" for averages in (0, FEW, many)])


if __name__ == "__main__":
    main()
