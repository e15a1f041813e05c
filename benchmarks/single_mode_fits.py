"""Batched single-mode fits against a Python loop over the same fits; Dobson's method against circle-fit."""

from functools import partial

import numpy as np

from benchmarks.bench import Bench
from benchmarks.timing import ratio
from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.single_mode.method import EXTRACTION_METHODS, ExtractionMethod

N_FITS = 10_000
N_LOOPED = 1_000  # of the same fits; the loop's time is in proportion
ROUNDS = 5
LIMIT = 1 / 50
AGAINST_CIRCLE = 10.0


def run(
    n_fits: int = N_FITS, n_looped: int = N_LOOPED, rounds: int = ROUNDS
) -> list[tuple[str, float, float]]:
    """Return (name, time in a batch over time one by one, limit) for every method, and Dobson over circle."""
    windows = _windows(n_fits)
    ratios = []
    for kind, method in EXTRACTION_METHODS.items():
        loop_time = ratio(partial(method, *windows), partial(_loop, method, n_looped, *windows), rounds)
        ratios.append((f"{n_fits} {kind} fits against a loop", loop_time * n_looped / n_fits, LIMIT))
    batches = [partial(EXTRACTION_METHODS[kind], *windows) for kind in ("dobson", "circle_fit")]
    against = ratio(batches[0], batches[1], rounds)
    return [*ratios, (f"{n_fits} dobson fits against as many circle fits", against, AGAINST_CIRCLE)]


def _windows(n_fits: int) -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Return eight lines round one mode each, with 1 % of noise."""
    rng = np.random.default_rng(0)
    freq: FloatArray = np.tile(np.arange(96.0, 104.0), (n_fits, 1)).astype(float)
    eigenvalue = (2 * np.pi * rng.uniform(99, 101, (n_fits, 1))) ** 2 * (1 + 0.01j)
    error = 0.01 * (rng.standard_normal(freq.shape) + 1j * rng.standard_normal(freq.shape))
    frf = np.asarray((1 + error) / (eigenvalue - (2 * np.pi * freq) ** 2), complex)
    return freq, frf, np.asarray(1 / (0.01 * np.abs(frf)) ** 2)


def _loop(
    method: ExtractionMethod, n_looped: int, freq: FloatArray, frf: ComplexArray, weight: FloatArray
) -> None:
    for i in range(n_looped):
        method(freq[i : i + 1], frf[i : i + 1], weight[i : i + 1])


BENCH = Bench(run, short=partial(run, n_fits=10, n_looped=2, rounds=1))
