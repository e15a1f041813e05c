"""Batched single-mode fits against a Python loop over the same fits; Dobson's method against circle-fit."""

from functools import partial

import numpy as np

from benchmarks.timing import ratio
from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.single_mode.method import EXTRACTION_METHODS, ExtractionMethod

N_FITS = 10_000
N_LOOPED = 1_000  # of the same fits; the loop's time is in proportion
ROUNDS = 5
LIMIT = 1 / 50
AGAINST_CIRCLE = 10.0


def run() -> list[tuple[str, float, float]]:
    """Return (name, time in a batch over time one by one, limit) for every method, and Dobson over circle."""
    windows = _windows()
    ratios = []
    for kind, method in EXTRACTION_METHODS.items():
        loop_time = ratio(partial(method, *windows), partial(_loop, method, *windows), ROUNDS)
        ratios.append((f"{N_FITS} {kind} fits against a loop", loop_time * N_LOOPED / N_FITS, LIMIT))
    batches = [partial(EXTRACTION_METHODS[kind], *windows) for kind in ("dobson", "circle_fit")]
    against = ratio(batches[0], batches[1], ROUNDS)
    return [*ratios, (f"{N_FITS} dobson fits against as many circle fits", against, AGAINST_CIRCLE)]


def _windows() -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Return eight lines round one mode each, with 1 % of noise."""
    rng = np.random.default_rng(0)
    freq: FloatArray = np.tile(np.arange(96.0, 104.0), (N_FITS, 1)).astype(float)
    eigenvalue = (2 * np.pi * rng.uniform(99, 101, (N_FITS, 1))) ** 2 * (1 + 0.01j)
    error = 0.01 * (rng.standard_normal(freq.shape) + 1j * rng.standard_normal(freq.shape))
    frf = np.asarray((1 + error) / (eigenvalue - (2 * np.pi * freq) ** 2), complex)
    return freq, frf, np.asarray(1 / (0.01 * np.abs(frf)) ** 2)


def _loop(method: ExtractionMethod, freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> None:
    for i in range(N_LOOPED):
        method(freq[i : i + 1], frf[i : i + 1], weight[i : i + 1])
