"""Averaging against what it cannot do without: one transform a channel, and the cross products."""

from functools import partial

import numpy as np
import scipy.fft

from benchmarks.bench import Bench
from benchmarks.timing import ratio
from modallab.estimation.averaging import Averager
from modallab.estimation.windows import WINDOWS

N_BLOCK, N_CH, N_SAMPLES, N_LINES = 100, 12, 8192, 3201
ROUNDS = 15


def run(n_block: int = N_BLOCK, rounds: int = ROUNDS) -> list[tuple[str, float, float]]:
    """Return the time of the averager over that of bare transforms and products."""
    records = np.random.default_rng(0).standard_normal((n_block, N_CH, N_SAMPLES))

    def averager() -> None:
        sums = Averager(WINDOWS["hann"], (N_CH, N_SAMPLES), 8192.0, n_lines=N_LINES, n_in=1)
        sums.add(records)
        sums.densities()

    def bare() -> None:
        ff, xx = np.zeros(N_LINES), np.zeros((N_CH - 1, N_LINES))
        fx = np.zeros((N_CH - 1, N_LINES), complex)
        for block in records:
            lines = scipy.fft.rfft(block)[:, :N_LINES]
            f, x = lines[0], lines[1:]
            ff += f.real**2 + f.imag**2
            fx += f.conj() * x
            xx += x.real**2 + x.imag**2

    name = f"estimation: {N_CH} channels, {n_block} blocks of {N_SAMPLES}, against rfft + products"
    return [(name, ratio(averager, bare, rounds), 1.2)]


BENCH = Bench(run, short=partial(run, n_block=2, rounds=1))
