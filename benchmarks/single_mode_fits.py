"""Batched single-mode fits against a Python loop over the same fits."""

import time

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.method import EXTRACTION_METHODS, ExtractionMethod

N_FITS = 10_000
N_LOOPED = 1_000  # of the same fits; the loop's time is in proportion
REPEATS = 3  # the quickest counts: what else the machine does only adds
LIMIT = 1 / 50


def run() -> list[tuple[str, float, float]]:
    """Return (name, time in a batch over time one by one, limit) for every method."""
    freq, frf, weight = _windows()
    ratios = []
    for kind, method in EXTRACTION_METHODS.items():
        together = min(_batch(method, freq, frf, weight) for _ in range(REPEATS))
        alone = min(_loop(method, freq, frf, weight) for _ in range(REPEATS)) * N_FITS / N_LOOPED
        ratios.append((f"{N_FITS} {kind} fits against a loop", together / alone, LIMIT))
    return ratios


def _windows() -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Return eight lines round one mode each, with 1 % of noise."""
    rng = np.random.default_rng(0)
    freq: FloatArray = np.tile(np.arange(96.0, 104.0), (N_FITS, 1)).astype(float)
    eigenvalue = (2 * np.pi * rng.uniform(99, 101, (N_FITS, 1))) ** 2 * (1 + 0.01j)
    error = 0.01 * (rng.standard_normal(freq.shape) + 1j * rng.standard_normal(freq.shape))
    frf = np.asarray((1 + error) / (eigenvalue - (2 * np.pi * freq) ** 2), complex)
    return freq, frf, np.asarray(1 / (0.01 * np.abs(frf)) ** 2)


def _batch(method: ExtractionMethod, freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> float:
    start = time.perf_counter()
    method(freq, frf, weight)
    return time.perf_counter() - start


def _loop(method: ExtractionMethod, freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> float:
    start = time.perf_counter()
    for i in range(N_LOOPED):
        method(freq[i : i + 1], frf[i : i + 1], weight[i : i + 1])
    return time.perf_counter() - start
