"""Drawn measurements against the random numbers they are made of."""

import numpy as np

from benchmarks.timing import ratio
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.drawn import drawn_spectra

N_TESTS, N_FREQ, N_OUT, AVERAGES = 1000, 401, 11, 100


def run() -> list[tuple[str, float, float]]:
    """Return the time of 1,000 tests over that of as many Gamma and normal variables."""
    shape = (1, N_FREQ, N_OUT)
    expected = CrossSpectra(
        np.linspace(0, 800, N_FREQ),
        np.ones((1, N_FREQ, 1, 1), complex),
        np.full((1, N_FREQ, 1, N_OUT), 1 + 1j),
        np.full(shape, 2.1),
        AVERAGES,
    )

    def drawn() -> None:
        drawn_spectra(expected, np.random.default_rng(0), N_TESTS)

    def numbers() -> None:
        rng = np.random.default_rng(0)
        for _ in range(N_TESTS):
            rng.standard_gamma(AVERAGES, N_FREQ)
            rng.standard_normal((N_FREQ, N_OUT, 2))
            rng.standard_gamma(AVERAGES - 1, (N_FREQ, N_OUT))

    return [("drawn: 1,000 tests of 11 x 401, against their random numbers", ratio(drawn, numbers, 5), 2.0)]
