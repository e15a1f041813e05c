"""Modes of a hammer test of which nothing but the points is declared.

python -m benchmarks.hammer_modes 10     # so many tests, a table of each

Forty struck points and three accelerometers, 12,801 lines, an exponential window, white noise of the channels
40 dB below their mean spectra. The file states FRFs, coherence and points; averages, window and noise are for
the import to estimate. Of 15 modes six form pairs 0.3 to 0.5 % apart.

Errors are held against 0.1 % of the frequency, 5 % of the structure's loss factor, and three times the
Cramer-Rao bound of the records without window, which takes no information away. The damping that the window
adds is subtracted; it is up to 1.6 times that of the structure.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import TextIO

import numpy as np
import scipy

from benchmarks.bench import Bench, Row, parser
from benchmarks.close_modes import (
    APART,
    AVERAGES,
    HammerTest,
    Size,
    Truth,
    imported,
    incoherent_power,
    mac,
    test_of,
    truth_of,
)
from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.core.modal_model import ModalModel
from modallab.estimation.windows import added_loss_factor
from modallab.extraction.extract import extract
from modallab.jobs.extracting import leakage_of
from modallab.rig.measurement import Measurement

N_TESTS = 10
METHOD = "poly_reference_lscf"

FREQUENCY_ERROR, DAMPING_ERROR, BOUNDS = 1e-3, 0.05, 3.0
NOISE_ERROR = 0.2
FULL = Size()
SAME_SHAPE = 0.9  # MAC


@dataclass(frozen=True, eq=False)
class Verdict:
    """Modes of a test beside the true ones."""

    found: IntArray
    """(15,) index of the extracted mode, -1 for none."""
    errors: FloatArray
    """(15, 2) of frequency and loss factor, relative; NaN where not found."""
    limits: FloatArray
    """(15, 2) relative."""
    bounds: FloatArray
    """(15, 2) Cramer-Rao bounds, relative."""
    visible: BoolArray
    """(15,) whether a mode is above the noise in some FRF."""
    confused: int
    """Pairs not told apart."""
    spurious: int
    """Extracted modes that are none."""
    noise: float
    """Relative error of the noise, of the FRF with the largest."""


def modes_of(test: Measurement) -> ModalModel:
    """Return the modes of an imported test, as a job extracts them."""
    return extract(
        test.frf,
        coherence=test.coherence,
        averages=test.averages,
        method=METHOD,
        leakage=leakage_of(test.setup),
        estimator=test.setup.analyser.estimator,
    )


def cramer_rao(truth: Truth, freq: FloatArray, variance: FloatArray) -> FloatArray:
    """Return the relative bounds of frequencies and loss factors, (15, 2).

    The unknowns are the eigenvalues of the modes in the band, a complex constant of each in every FRF, and
    what modes above the band add to it: a constant receptance.
    """
    omega = 2 * np.pi * freq[1:, None]
    square = (2 * np.pi * truth.frequency) ** 2
    eigenvalue = square * (1 + 1j * truth.loss_factor)
    poles = 1 / (eigenvalue - omega**2)
    linear = -(omega**2) * np.hstack([poles, np.ones_like(omega)])
    slopes = omega**2 * poles**2
    constants = truth.constants[: len(square)].transpose(0, 2, 1).reshape(len(square), -1)
    fisher = np.zeros((len(square), len(square)), complex)
    for constant, power in zip(constants.T, variance[1:].reshape(len(omega), -1).T, strict=True):
        weight = 1 / np.sqrt(power)[:, None]
        q = np.linalg.qr(weight * linear)[0]
        columns = weight * slopes * constant
        free = columns - q @ (q.conj().T @ columns)
        fisher += free.conj().T @ free
    # of a circular complex error half the power is in either part
    part = np.sqrt(np.diag(np.linalg.inv(fisher)).real / 2)
    return np.column_stack([part / (2 * square), part / (square * truth.loss_factor)])


def judged(truth: Truth, test: HammerTest, read: Measurement, model: ModalModel) -> Verdict:
    """Return the modes beside the true ones."""
    setup = test.measured.setup.analyser
    bounds = cramer_rao(truth, read.frf.freq, test.variance)
    limits = np.maximum([[FREQUENCY_ERROR, DAMPING_ERROR]], BOUNDS * bounds)
    added = added_loss_factor(setup.line_window.end, setup.record_length, model.frequencies)
    off = np.abs(model.frequencies / truth.frequency[:, None] - 1)
    row, assigned = scipy.optimize.linear_sum_assignment(np.minimum(off, APART[0]))
    near = off[row, assigned] < APART[0]
    found = np.full(len(truth.frequency), -1)
    found[row[near]] = assigned[near]
    errors = np.full((len(found), 2), np.nan)
    errors[found >= 0, 0] = (model.frequencies[found] / truth.frequency - 1)[found >= 0]
    errors[found >= 0, 1] = ((model.loss_factors - added)[found] / truth.loss_factor - 1)[found >= 0]
    peak = np.abs(truth.constants[: len(found)]).transpose(0, 2, 1) / truth.loss_factor[:, None, None]
    at_peak = np.searchsorted(read.frf.freq, truth.frequency)
    shape = np.array([mode.shape for mode in model.modes])
    confused = sum(
        any(found[m] < 0 or mac(truth.shapes[:, m], shape[found[m]]) < SAME_SHAPE for m in pair)
        for pair in truth.pairs
    )
    return Verdict(
        found,
        errors,
        limits,
        bounds,
        np.asarray((peak > np.sqrt(test.variance[at_peak])).any(axis=(1, 2))),
        confused,
        len(model.modes) - int((found >= 0).sum()),
        noise_error(test, read),
    )


def noise_error(test: HammerTest, read: Measurement) -> float:
    """Return the relative error of the rms noise that coherence and estimated averages tell, the largest."""
    told = incoherent_power(read)[1:] / (read.averages - 1)
    return float(np.abs(np.sqrt((told / test.true[1:]).mean(axis=0)) - 1).max())


def verdict_of(seed: int, size: Size, out: TextIO | None = None) -> Verdict:
    """Return the verdict on the test of a seed, and print its table."""
    truth = truth_of(seed, size)
    test = test_of(truth, seed, size)
    read = imported(test.measured)
    verdict = judged(truth, test, read, modes_of(read))
    if out is not None:
        averages = next(each.value for each in read.assumed if each.quantity == "averages")
        print(f"test {seed}: averages {averages}, {AVERAGES} are true", file=out)
        print(*table(truth, verdict), sep="\n", file=out, flush=True)
    return verdict


def table(truth: Truth, verdict: Verdict) -> Iterator[str]:
    """Yield the lines of a test's table."""
    yield "      Hz   loss factor   error %   limit    bound   damping error %   limit    bound"
    for m, frequency in enumerate(truth.frequency):
        error, limit, bound = (100 * part[m] for part in (verdict.errors, verdict.limits, verdict.bounds))
        mark = "" if verdict.visible[m] else "  below the noise in every FRF, not counted"
        yield (
            f"{frequency:8.2f}    {truth.loss_factor[m]:8.5f}  "
            f"{error[0]:8.5f} {limit[0]:7.3f} {bound[0]:8.1e}   "
            f"{error[1]:15.3f} {limit[1]:7.3f} {bound[1]:8.1e}{mark}"
        )
    yield (
        f"{verdict.confused} pairs confused, {verdict.spurious} spurious modes, "
        f"noise {100 * verdict.noise:.1f} % off at most"
    )


def rows_of(verdicts: list[Verdict]) -> list[Row]:
    """Return (name, figure, limit) over all tests."""
    missed = sum(int((verdict.visible & (verdict.found < 0)).sum()) for verdict in verdicts)
    ratio = [
        np.where((verdict.visible & (verdict.found >= 0))[:, None], np.abs(verdict.errors), 0)
        / verdict.limits
        for verdict in verdicts
    ]
    worst = np.concatenate(ratio).max(axis=0)
    return [
        ("undeclared hammer test: modes not found", float(missed), 0.0),
        ("undeclared hammer test: worst frequency over its limit", float(worst[0]), 1.0),
        ("undeclared hammer test: worst damping over its limit", float(worst[1]), 1.0),
        ("undeclared hammer test: pairs confused", float(sum(v.confused for v in verdicts)), 0.0),
        ("undeclared hammer test: spurious modes", float(sum(v.spurious for v in verdicts)), 0.0),
        ("undeclared hammer test: noise, relative error", max(v.noise for v in verdicts), NOISE_ERROR),
    ]


def run(n_tests: int = N_TESTS, size: Size = FULL, out: TextIO | None = None) -> list[Row]:
    """Return (name, figure, limit)."""
    return rows_of([verdict_of(seed, size, out) for seed in range(n_tests)])


BENCH = Bench(run, short=partial(run, n_tests=1, size=Size(n_points=20, n_lines=1601)))


def main() -> None:
    """Print the table of each test, and exit with 1 if a figure is over its limit."""
    arguments = parser(__doc__)
    arguments.add_argument("tests", type=int, nargs="?", default=N_TESTS, help="default: %(default)s")
    arguments.add_argument("--points", type=int, default=Size.n_points, help="default: %(default)s")
    arguments.add_argument("--lines", type=int, default=Size.n_lines, help="default: %(default)s")
    options = arguments.parse_args()
    rows = run(options.tests, Size(options.points, options.lines), sys.stdout)
    for name, figure, limit in rows:
        verdict = "" if figure <= limit else "OVER"
        print(f"{name:<60} {figure:8.3g}  limit {limit:<6.3g}  {verdict}".rstrip())
    if any(figure > limit for _, figure, limit in rows):
        sys.exit(1)


if __name__ == "__main__":
    main()
