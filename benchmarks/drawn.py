"""Drawn measurements against the random numbers they are made of."""

from functools import partial

import numpy as np

from benchmarks.bench import Bench
from benchmarks.timing import ratio
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.wishart import wishart_spectra

N_TESTS, N_FREQ, N_OUT, AVERAGES = 1000, 401, 11, 100
FEWER = 200  # tests of several forces
ROUNDS = 5


def run(n_tests: int = N_TESTS, fewer: int = FEWER, rounds: int = ROUNDS) -> list[tuple[str, float, float]]:
    """Return the time of many tests over that of as many Gamma and normal variables."""
    name = f"against their random numbers, 11 x {N_FREQ}"
    return [
        (f"drawn: {n_tests:,} tests, {name}", against_numbers(1, n_tests, rounds), 2.0),
        (f"drawn: two forces, {fewer} tests, {name}", against_numbers(2, fewer, rounds), 3.0),
    ]


def against_numbers(n_in: int, n_tests: int, rounds: int) -> float:
    """Return the time of tests with `n_in` forces over that of the random numbers they are made of."""
    expected = CrossSpectra(
        np.linspace(0, 800, N_FREQ),
        np.tile(np.eye(n_in, dtype=complex), (1, N_FREQ, 1, 1)),
        np.full((1, N_FREQ, n_in, N_OUT), 1 + 1j),
        np.full((1, N_FREQ, N_OUT), 2.1 * n_in),
        AVERAGES,
    )
    ties = n_in * (n_in - 1) // 2

    def draw() -> None:
        wishart_spectra(expected, np.random.default_rng(0), n_tests)

    def numbers() -> None:
        rng = np.random.default_rng(0)
        for _ in range(n_tests):
            rng.standard_gamma(AVERAGES, (N_FREQ, n_in))
            rng.standard_normal((N_FREQ, ties, 2))
            rng.standard_normal((N_FREQ, n_in, N_OUT, 2))
            rng.standard_gamma(AVERAGES - n_in, (N_FREQ, N_OUT))

    return ratio(draw, numbers, rounds)


BENCH = Bench(run, short=partial(run, n_tests=2, fewer=2, rounds=1))
