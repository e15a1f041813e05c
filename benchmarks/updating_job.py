"""A plate of 100,000 degrees of freedom updated in one job of a service: its memory, and what it finds.

python -m benchmarks updating_job            # prints the seconds of every request too
"""

import os
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from benchmarks.bench import Bench
from benchmarks.updating_scale import (
    LENGTH,
    MACROS,
    MEASURED,
    MEMORY,
    SIZES,
    STEEL,
    STEPS,
    THICKNESS,
    WIDTH,
    WRONG,
    patches,
    sensors,
)
from modallab_client import ModalLab
from modallab_client.results import IterativeUpdate

N_DOFS = 100_000
PATIENCE = 600.0  # s for one reply: modes of the true plate are solved for while one waits


@contextmanager
def timed(label: str) -> Iterator[None]:
    """Print how long something took."""
    start = time.monotonic()
    yield
    print(f"  {label:<30} {time.monotonic() - start:6.1f} s", flush=True)


def children(process: int) -> Iterator[int]:
    """Yield the processes that one started, and those that these did."""
    for thread in Path(f"/proc/{process}/task").iterdir():
        for child in map(int, (thread / "children").read_text().split()):
            yield child
            yield from children(child)


def peak_memory(process: int) -> int:
    """Return the most memory that a process held, kB."""
    match = re.search(r"VmHWM:\s*(\d+) kB", Path(f"/proc/{process}/status").read_text())
    return int(match[1]) if match else 0


def updated(n_dofs: int = N_DOFS) -> tuple[float, float]:
    """Return the most memory, kB, that a process of the service held, and the largest error found."""
    groups = [list(group) for group in patches(n_dofs, MACROS)]
    wrong = [{"members": groups[i], "property": "modulus", "factor": f} for i, f in WRONG.items()]
    dofs = [str(dof) for dof in sensors(n_dofs)]
    with ModalLab.embedded(timeout=PATIENCE) as lab:
        with timed("model, and one changed"):
            plate = lab.structures.plate(
                length=LENGTH,
                width=WIDTH,
                thickness=THICKNESS,
                n_elements=SIZES[n_dofs],
                material={"modulus": STEEL.modulus, "density": STEEL.density},
            )
            true = lab.structures.change(plate.id, wrong)
        with timed(f"{MEASURED} modes of it"):
            measured = lab.structures.synthetic_modes(true.id, dofs=dofs, count=MEASURED)
        with timed("update"):
            options = {"max_iterations": STEPS, "tolerance": 1e-12}
            job = lab.updates.start(plate.id, measured.id, method="one_shot", macros=groups, options=options)
            match = job.result()
        memory = max(peak_memory(process) for process in children(os.getpid()))
    assert isinstance(match, IterativeUpdate)
    assert match.iterations["updating"] == STEPS
    errors = [
        abs(match.coefficients[part][group[0]] - (WRONG.get(i, 1.0) if part == "stiffness" else 1.0))
        for part in ("mass", "stiffness")
        for i, group in enumerate(groups)
    ]
    return memory, max(errors)


def run(n_dofs: int = N_DOFS) -> list[tuple[str, float, float]]:
    """Return (name, figure, limit)."""
    memory, error = updated(n_dofs)
    whole = f"{n_dofs:,} DoFs, {2 * MACROS[0] * MACROS[1]} coefficients, {STEPS} steps, one job"
    return [(f"{whole}: memory over 24 GB", memory / MEMORY, 1.0), (f"{whole}: largest error", error, 1e-3)]


BENCH = Bench(run, short=partial(run, n_dofs=600), reads_proc=True)
