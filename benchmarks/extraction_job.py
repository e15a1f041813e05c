"""Twenty modes from 500 FRFs of 3,201 lines in one job of a service: its time, its memory, what it tells.

Not part of `make bench`: up to a minute for each method.

    python -m benchmarks.extraction_job
"""

import io
import os
import time
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.bench import parser
from benchmarks.updating_job import children, peak_memory
from modallab.core.arrays import ComplexArray, FloatArray
from modallab_client import ModalLab

N_FRF, N_LINES, N_MODES = 500, 3201, 20
TOP = 800.0  # Hz
LOSS = 0.005
AVERAGES = 100.0
NOISE = 0.01  # standard deviation of each line as mobility, of the rms of its FRF
METHODS = ("dobson", "lscf")
TICK = os.sysconf("SC_CLK_TCK")
PATIENCE = 600.0  # s for one reply


def measured(n_frf: int = N_FRF, n_lines: int = N_LINES) -> tuple[FloatArray, bytes]:
    """Return natural frequencies, Hz, and a measurement of inertances with coherence as npz."""
    rng = np.random.default_rng(0)
    freq: FloatArray = np.linspace(0.0, TOP, n_lines)
    natural = np.linspace(30.0, TOP - 30.0, N_MODES) + rng.uniform(-8, 8, N_MODES)
    omega = 2 * np.pi * freq[:, None]
    shapes = rng.standard_normal((N_MODES, n_frf))
    shapes[:, 0] = 1.0  # the drive point is near no node
    exact: ComplexArray = -(omega**2) / ((2 * np.pi * natural) ** 2 * (1 + 1j * LOSS) - omega**2)
    exact = exact @ (shapes[:, :1] * shapes)
    mobility = np.abs(exact[1:] / omega[1:])
    error = NOISE * omega * np.sqrt((mobility**2).mean(axis=0))
    unit = rng.standard_normal(exact.shape) + 1j * rng.standard_normal(exact.shape)
    noisy = exact + error / np.sqrt(2) * unit
    coherence = 1 / (1 + AVERAGES * error**2 / np.maximum(np.abs(exact) ** 2, 1e-30))
    file = io.BytesIO()
    np.savez(
        file,
        freq=freq,
        values=noisy[:, :, None],
        coherence=coherence,
        averages=AVERAGES,
        outputs=[f"{node}:+Z" for node in range(1, n_frf + 1)],
        inputs=["1:+Z"],
        kind="inertance",
    )
    return natural, file.getvalue()


def spent(process: int) -> float:
    """Return the processor time, s, that a process has used."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICK


def main() -> None:
    """Print the figures."""
    arguments = parser(__doc__)
    arguments.add_argument("--frfs", type=int, default=N_FRF)
    arguments.add_argument("--lines", type=int, default=N_LINES)
    arguments.add_argument("--methods", nargs="+", default=METHODS, metavar="method")
    options = arguments.parse_args()
    natural, payload = measured(options.frfs, options.lines)
    print(
        f"{options.frfs} FRFs x {options.lines} lines x {N_MODES} modes, {len(payload) / 1e6:.0f} MB as npz"
    )
    with ModalLab.embedded(timeout=PATIENCE) as lab:
        begun = time.monotonic()
        test = lab.measurements.upload(payload)
        print(f"uploaded in {time.monotonic() - begun:.1f} s")
        for method in options.methods:
            progress: list[tuple[float, float]] = []
            begun, cpu_before = time.monotonic(), sum(map(spent, children(os.getpid())))

            def note(
                fraction: float, _: str, progress: list[tuple[float, float]] = progress, at: float = begun
            ) -> None:
                progress.append((time.monotonic() - at, fraction))

            modes = lab.modal_models.start(test.id, method=method, n_modes=N_MODES).result(on_progress=note)
            took = time.monotonic() - begun
            silence = max(b - a for (a, _), (b, _) in pairwise([(0.0, 0.0), *progress, (took, 1.0)]))
            remaining = max((modes.resynthesis_error or {}).values(), default=np.nan)
            off = np.abs(modes.frequencies / natural - 1).max()
            rising = all(a <= b for (_, a), (_, b) in pairwise(progress))
            memory = max(map(peak_memory, children(os.getpid()))) / 1e6
            worked = sum(map(spent, children(os.getpid()))) - cpu_before
            print(
                f"{method:<8} {took:6.1f} s, {worked:.1f} s of work, {memory:.2f} GB; {len(progress)} reports"
                f"{'' if rising else ', NOT rising'}, longest silence {silence:.1f} s; "
                f"{len(modes.modes)} modes, frequencies within {off:.1e}, "
                f"{100 * remaining:.1f} % left",
                flush=True,
            )


if __name__ == "__main__":
    main()
