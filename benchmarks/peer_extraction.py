"""Speed of global extraction against the poles of sdypy-EMA, with the same FRFs on one thread.

    python -m venv /tmp/peer && /tmp/peer/bin/pip install sdypy-EMA
    PEER_PYTHON=/tmp/peer/bin/python python -m benchmarks peer_extraction

P is the processor time of the peer's `get_poles` at order 60. It does less: no selection of modes, no
refinement, no standard errors. Without the peer, only the memory is measured.

Frequencies of both are compared with the exact ones, in our standard errors. Those of the peer are of its
poles at the highest order nearest to the exact ones, which is kinder than its own `select_closest_poles`:
that one takes 100.5 and 105 Hz for one mode at 102.9 Hz.
"""

import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.bench import Bench
from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.extract import extract
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS
from modallab.extraction.multi_mode.stabilisation import stabilise

ORDER, ROUNDS = 60, 5
N_FRF, N_LINES, N_REFERENCES, FEW_FRFS = 222, 1601, 3, 6
HIGHEST = 400.0  # Hz, of the lines
NOISE = 0.01  # of the rms of an FRF
FREQUENCY = np.array(
    [18.6, 48.3, 100.5, 105.0, 145.2, 148.5, 165.6, 189.0, 199.5, 308.7, 315.6, 375.6, 376.7]
)
CHART_LIMIT, WHOLE_LIMIT, POLY_CHART_LIMIT, POLY_WHOLE_LIMIT = 1.5, 6.0, 15.0, 40.0
FEW_CHART_LIMIT, FEW_WHOLE_LIMIT, FEW_SECONDS = 1.0, 3.0, 0.5
MEMORY_LIMIT = 0.6  # GB
STANDARD_ERRORS = 3.0
PEER = """
import sys, time
import numpy as np
try:
    from sdypy.EMA import Model
except ImportError:
    sys.exit(1)
data = np.load(sys.argv[1])
model = Model(frf=data["frf"], freq=data["freq"], lower=float(data["freq"][1]), upper=float(data["freq"][-1]),
              pol_order_high=int(sys.argv[2]))
print("ready", flush=True)
for line in sys.stdin:
    begun = time.process_time()
    if line.strip() == "poles":
        model.get_poles(show_progress=False)
        print(time.process_time() - begun, flush=True)
    else:
        frequency, ratio = np.asarray(model.pole_freq[-1]), np.asarray(model.pole_xi[-1])
        frequency = frequency[ratio > 0]
        near = np.array([float(value) for value in line.split()])
        print(*frequency[np.abs(frequency[:, None] - near).argmin(axis=0)].tolist(), flush=True)
"""


@dataclass(frozen=True, eq=False)
class Arrays:
    """FRFs of viscous modes with noise, as both get them."""

    frf: FrfSet
    weight: FloatArray

    def chart(self, method: str, order: int) -> object:
        """Return the stability of the poles of all orders."""
        lines = slice(1, None)
        shape = (len(self.frf.freq), -1, 1) if method == "lscf" else self.frf.values.shape
        values, weight = self.frf.values.reshape(shape), self.weight.reshape(shape)
        find = GLOBAL_METHODS[method]
        return stabilise(find(self.frf.freq[lines], values[lines], weight[lines], np.arange(2, order + 1)))

    def whole(self, method: str) -> ModalModel:
        """Return the modal model with default options."""
        return extract(self.frf, coherence=None, averages=1.0, method=method)


def arrays(n_frf: int, n_references: int = 1, n_lines: int = N_LINES) -> Arrays:
    """Return inertances of thirteen modes, damping ratios 0.3 to 1.3 %, two pairs 0.3 and 2 % apart."""
    rng = np.random.default_rng(3)
    freq: FloatArray = np.linspace(0.0, HIGHEST, n_lines)
    omega, natural = 2 * np.pi * freq[:, None], 2 * np.pi * FREQUENCY
    loss_factor = rng.uniform(0.006, 0.026, len(natural))
    shapes = rng.standard_normal((len(natural), n_frf // n_references))
    driven = (
        rng.standard_normal((len(natural), n_references)) if n_references > 1 else np.ones((len(natural), 1))
    )
    constant = (shapes[:, :, None] * driven[:, None]).reshape(len(natural), -1)
    modes = -(omega**2) / (natural**2 - omega**2 + 1j * loss_factor * natural * omega)
    exact: ComplexArray = np.asarray(modes @ constant, complex)
    level = NOISE * np.sqrt(np.mean(np.abs(exact) ** 2, axis=0))
    unit = (rng.standard_normal(exact.shape) + 1j * rng.standard_normal(exact.shape)) / np.sqrt(2)
    values = (exact + level * unit).reshape(n_lines, -1, n_references)
    outputs = tuple(Dof(node, "Z") for node in range(1, values.shape[1] + 1))
    frf = FrfSet(freq, values, outputs, outputs[:n_references], FrfKind.INERTANCE)
    return Arrays(frf, np.broadcast_to(level**-2.0, exact.shape))


def seconds(run: Callable[[], object]) -> float:
    """Return the processor time of a call."""
    begun = time.process_time()
    run()
    return time.process_time() - begun


@dataclass(frozen=True)
class Peer:
    """The peer in a process of its own."""

    process: subprocess.Popen[str]

    def seconds(self) -> float:
        """Return the processor time of `get_poles`."""
        return float(self._answer("poles"))

    def frequencies(self, near: FloatArray) -> FloatArray:
        """Return the frequencies of its poles at the highest order nearest to given ones, Hz."""
        return np.array(self._answer(" ".join(map(repr, near.tolist()))).split(), float)

    def _answer(self, question: str) -> str:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        print(question, file=self.process.stdin, flush=True)
        return self.process.stdout.readline()


@contextmanager
def peer_of(data: Arrays, order: int) -> Iterator[Peer | None]:
    """Yield the peer with these FRFs; None where it is not installed."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "frf.npz")
        values = data.frf.values.reshape(len(data.frf.freq), -1).T
        np.savez(path, frf=values, freq=data.frf.freq)
        python = os.environ.get("PEER_PYTHON", sys.executable)
        command = [python, "-c", PEER, str(path), str(order)]
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PYTHONPATH": ""}
        with subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env=environment,
        ) as process:
            assert process.stdout is not None
            ready = any("ready" in line for line in iter(process.stdout.readline, ""))
            yield Peer(process) if ready else None
            process.terminate()


def against(data: Arrays, method: str, peer: Peer, order: int, rounds: int) -> tuple[float, float, float]:
    """Return P, and the medians of our chart and whole extraction over it, of alternating rounds."""
    times = np.array(
        [
            (peer.seconds(), seconds(lambda: data.chart(method, order)), seconds(lambda: data.whole(method)))
            for _ in range(rounds)
        ]
    )
    chart, whole = (statistics.median((times[:, n] / times[:, 0]).tolist()) for n in (1, 2))
    return statistics.median(times[:, 0].tolist()), chart, whole


def compared(model: ModalModel, peer: Peer) -> list[tuple[str, float, float]]:
    """Return how many modes ours misses, and how many the peer has nearer, and print the errors of both.

    Of the peer count the modes that it has within half a bandwidth. It states no standard errors: where both
    differ by three of ours, the exact frequencies tell whose error it is.
    """
    mode = np.abs(model.frequencies - FREQUENCY[:, None]).argmin(axis=1)
    error = np.array([model.modes[m].standard_errors["frequency"] for m in mode.tolist()])
    found = peer.frequencies(FREQUENCY)
    near = np.abs(found - FREQUENCY) < 0.5 * (model.loss_factors * model.frequencies)[mode]
    ours, peers = ((values - FREQUENCY) / error for values in (model.frequencies[mode], found))
    differ = near & (np.abs(ours - peers) > STANDARD_ERRORS)
    print("frequency, Hz   standard error   error of ours   of the peer, in standard errors")
    for row in zip(FREQUENCY, error, ours, np.where(near, peers, np.nan), strict=True):
        print("{:13.1f} {:16.2g} {:15.2f} {:13.2f}".format(*row))
    print(
        f"{np.count_nonzero(differ)} of the {np.count_nonzero(near)} modes that the peer finds differ from"
        f" ours by {STANDARD_ERRORS:g} standard errors",
        flush=True,
    )
    missed = np.count_nonzero(np.abs(ours) > STANDARD_ERRORS) + abs(len(model.modes) - len(FREQUENCY))
    worse = np.count_nonzero(differ & (np.abs(ours) > np.abs(peers)))
    return [
        ("modes of lscf missed by 3 standard errors, or too many", float(missed), 0.0),
        ("modes on which both differ, and the peer is nearer to the truth", float(worse), 0.0),
    ]


def memory(n_frf: int, n_lines: int) -> float:
    """Return the memory, GB, that an extraction in a process of its own adds to its arrays."""
    peaks = []
    for does in ("data", "data.whole('lscf')"):
        code = (
            "from benchmarks import peer_extraction as bench; "
            f"data = bench.arrays({n_frf}, n_lines={n_lines}); {does}; print(bench.peak())"
        )
        run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        peaks.append(float(run.stdout))
    return peaks[1] - peaks[0]


def peak() -> float:
    """Return the most memory, GB, that this process had."""
    found = re.search(r"VmHWM:\s*(\d+) kB", Path("/proc/self/status").read_text())
    assert found is not None
    return int(found[1]) / 1e6


def run(
    n_frf: int = N_FRF, n_lines: int = N_LINES, order: int = ORDER, rounds: int = ROUNDS
) -> list[tuple[str, float, float]]:
    """Return (name, time over that of the peer, or memory in GB, limit)."""
    name = f"{n_frf} FRFs x {n_lines} lines"
    rows = [(f"memory of lscf, {name}, GB", memory(n_frf, n_lines), MEMORY_LIMIT)]
    data = arrays(n_frf, n_lines=n_lines)
    with peer_of(data, order) as peer:
        if peer is None:
            print(
                "peer_extraction: SPEED IS SKIPPED, sdypy-EMA is not installed; see the docstring", flush=True
            )
            return rows
        unit, chart, whole = against(data, "lscf", peer, order, rounds)
        print(f"P = {unit:.3f} s, {name}", flush=True)
        rows += [(f"chart of lscf, {name}, over P", chart, CHART_LIMIT)]
        rows += [(f"whole lscf, {name}, over P", whole, WHOLE_LIMIT)]
        rows += compared(data.whole("lscf"), peer)
    several = arrays(n_frf, N_REFERENCES, n_lines)
    with peer_of(several, order) as peer:
        assert peer is not None
        _, chart, whole = against(several, "poly_reference_lscf", peer, order, max(1, rounds // 2))
        rows += [(f"chart of poly-reference, {N_REFERENCES} references, over P", chart, POLY_CHART_LIMIT)]
        rows += [(f"whole poly-reference, {N_REFERENCES} references, over P", whole, POLY_WHOLE_LIMIT)]
    few = arrays(FEW_FRFS, n_lines=n_lines)
    with peer_of(few, order) as peer:
        assert peer is not None
        unit, chart, whole = against(few, "lscf", peer, order, rounds)
        print(f"P = {unit:.3f} s, {FEW_FRFS} FRFs", flush=True)
        rows += [(f"chart of lscf, {FEW_FRFS} FRFs, over P", chart, FEW_CHART_LIMIT)]
        rows += [
            (
                f"whole lscf less {FEW_SECONDS} s, {FEW_FRFS} FRFs, over P",
                whole - FEW_SECONDS / unit,
                FEW_WHOLE_LIMIT,
            )
        ]
    return rows


BENCH = Bench(run, short=partial(run, n_frf=12, n_lines=401, order=20, rounds=1), reads_proc=True)
