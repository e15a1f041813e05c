"""A stabilisation chart of all orders against the eigenvalue problems that it contains."""

from functools import partial

import numpy as np

from benchmarks.bench import Bench
from benchmarks.timing import ratio
from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.multi_mode.fraction_poles import companions
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS
from modallab.extraction.multi_mode.matrix_fraction import fit_fractions, to_z_domain

N_FRF, N_LINES, ORDER = 11, 801, 40
N_MODES = 8
LIMIT = 1.3
ROUNDS = 60  # a chart takes some ten milliseconds


def run(order: int = ORDER, rounds: int = ROUNDS) -> list[tuple[str, float, float]]:
    """Return (name, time of the whole chart over that of its eigenvalue problems alone, limit)."""
    freq, frf, weight = _frfs()
    orders = np.arange(1, order + 1)
    find = GLOBAL_METHODS["lscf"]
    fractions = fit_fractions(to_z_domain(frf, weight, order), orders)
    problems = [companion.copy() for companion in companions(fractions.denominator, orders)]
    took = ratio(
        lambda: find(freq, frf, weight, orders),
        lambda: [np.linalg.eigvals(problem) for problem in problems],
        rounds,
    )
    name = f"lscf, {N_FRF} FRFs x {N_LINES} lines, orders to {order}, against its eigenvalues"
    return [(name, took, LIMIT)]


def _frfs() -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Return mobilities of eight modes with noise 40 dB below the rms of each."""
    rng = np.random.default_rng(0)
    freq: FloatArray = np.linspace(0.0, 800.0, N_LINES + 1)[1:]
    omega, natural = 2 * np.pi * freq[:, None], 2 * np.pi * np.linspace(60, 740, N_MODES)
    shapes = rng.standard_normal((N_MODES, N_FRF))
    exact = 1j * omega * (1 / (natural**2 * (1 + 0.01j) - omega**2)) @ (shapes[:, :1] * shapes)
    level = 0.01 * np.sqrt(np.mean(np.abs(exact) ** 2, axis=0))
    unit = (rng.standard_normal(exact.shape) + 1j * rng.standard_normal(exact.shape)) / np.sqrt(2)
    frf = np.asarray(exact + level * unit, complex)[:, :, None]
    return freq, frf, np.broadcast_to(1 / level[:, None] ** 2, frf.shape)


BENCH = Bench(run, short=partial(run, order=20, rounds=1))
