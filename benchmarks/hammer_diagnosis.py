"""Diagnosis of a stranger's hammer test through HTTP: is the wrong element named, how long, with what memory?

Twenty-seven points of a free beam are struck, an accelerometer listens at one: 3,201 lines between 40 and
900 Hz in one file without a rig. Neither noise nor level nor averages are declared. The model is exact but
for one element. Service and job have one core; memory is that of the service's largest process.

    python -m benchmarks hammer_diagnosis
"""

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np

from benchmarks.bench import Bench, Row
from benchmarks.extraction_job import spent
from benchmarks.updating_job import children, peak_memory
from modallab_client import ModalLab

N_POINTS = 27
TOP, LOWEST = 900.0, 40.0  # Hz
N_LINES = 3201
WRONG_ELEMENT, FACTOR = 8, 0.8
SECONDS, MEMORY = 60.0, 1.5e6  # kB
PATIENCE = 600.0  # s for one reply
BEAM: dict[str, Any] = {
    "kind": "beam",
    "length": 1.5,
    "section": {"area": 4.8e-4, "second_moment": 5.76e-9},
    "material": {"modulus": 7.1e10, "density": 2700.0},
    "damping": {"law": "structural", "stiffness_coefficient": 0.01},
}
ANALYSER = {"averages": 5, "excitation": {"kind": "impact", "level_scatter": 0.2}}
NOISE = {"force": {"psd": 2e-8}, "response": {"psd": 1e-3}}  # N^2/Hz, (m/s^2)^2/Hz


@contextmanager
def one_core() -> Iterator[None]:
    """Keep this process, and those it starts, on one core."""
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(allowed)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, allowed)


def file_of(lab: ModalLab, model: str, n_points: int, n_lines: int, wrong: int) -> bytes:
    """Return the test of the real beam as npz: frequencies, FRFs, coherence and points, nothing else."""
    first = round(LOWEST / (TOP - LOWEST) * (n_lines - 1))
    points = [f"{node}:+Y" for node in range(1, n_points + 1)]
    real = lab.structures.change(model, members=[wrong], property="modulus", factor=FACTOR)
    analyser = ANALYSER | {"frequency_max": TOP, "n_lines": first + n_lines}
    rig = lab.rigs.create(
        drives=points, responses=points[-1:], exciter={"kind": "hammer"}, analyser=analyser, noise=NOISE
    )
    test = lab.measurements.start(real.id, rig.id, seed=1, route="sampled").result()
    assert test.coherence is not None
    file = io.BytesIO()
    np.savez(
        file,
        freq=test.freq[first:],
        values=test.values[first:],
        coherence=test.coherence[first:],
        outputs=points[-1:],
        inputs=points,
        kind="inertance",
    )
    return file.getvalue()


def run(n_points: int = N_POINTS, n_lines: int = N_LINES, **options: Any) -> list[Row]:
    """Return (name, figure, limit): what is missed, seconds and memory over what is allowed."""
    wrong = min(WRONG_ELEMENT, n_points // 2)
    with one_core(), ModalLab.embedded(timeout=PATIENCE) as lab:
        model = lab.structures.create(**BEAM, n_elements=n_points - 1)
        content = file_of(lab, model.id, n_points, n_lines, wrong)
        test = lab.measurements.upload(content)
        before = sum(map(spent, children(os.getpid())))
        diagnosis = lab.diagnoses.start(model.id, test.id, **options).result()
        seconds = sum(map(spent, children(os.getpid()))) - before
        memory = max(map(peak_memory, children(os.getpid())))
    found = [(step.effect.kind, str(step.effect.at)) for step in diagnosis.steps]
    print(
        f"  {test.values.shape}, {test.freq[0]:.1f} to {test.freq[-1]:.1f} Hz: {diagnosis.verdict}, {found}"
    )
    for step in diagnosis.steps:
        print(f"  {step.effect.parameters}")
    for note in diagnosis.notes:
        print(f"  {note}")
    print(f"  {seconds:.1f} s, {memory / 1e6:.2f} GB", flush=True)
    whole = f"diagnosis of {n_points} blows x 1 reference x {n_lines:,} lines"
    missed = float(found != [("stiffness_error", str({"members": [wrong]}))])
    return [
        (f"{whole}: wrong element not named", missed, 0.0),
        (f"{whole}: processor time over {SECONDS:.0f} s", seconds / SECONDS, 1.0),
        (f"{whole}: memory over {MEMORY / 1e6} GB", memory / MEMORY, 1.0),
    ]


BENCH = Bench(run, short=partial(run, n_points=6, n_lines=201, suspects=["stiffness_error"]), reads_proc=True)
