"""FRF synthesis from modes against a plain matrix product of the same size."""

from functools import partial

import numpy as np

from benchmarks.bench import Bench
from benchmarks.timing import ratio
from modallab.fe.modes import ModalBasis

N_MODES, N_OUT, N_IN, N_FREQ = 234, 72, 3, 801
ROUNDS = 15


def run(n_freq: int = N_FREQ, rounds: int = ROUNDS) -> list[tuple[str, float, float]]:
    """Return the time of a receptance by modal sum over that of one dgemm."""
    rng = np.random.default_rng(0)
    eigenvalues = np.linspace(1.0, 1e3, N_MODES).astype(complex) ** 2 * (1 + 0.01j)
    basis = ModalBasis(eigenvalues, rng.standard_normal((N_OUT, N_MODES)), 0)
    response = basis.at(np.linspace(1.0, 900.0, n_freq))
    difference, right = np.eye(N_OUT), np.eye(N_OUT)[:, :N_IN]
    a = rng.standard_normal((2 * n_freq, N_MODES))
    b = rng.standard_normal((N_MODES, N_OUT * N_IN))

    return [
        (
            f"FRF synthesis: {N_MODES} modes x {N_OUT} x {N_IN} x {n_freq} lines, against dgemm",
            ratio(lambda: response.receptance(difference, right), lambda: a @ b, rounds),
            1.3,
        ),
        (
            "FRF synthesis with the modes' denominators, against dgemm",
            ratio(lambda: basis.at(response.omega).receptance(difference, right), lambda: a @ b, rounds),
            2.0,
        ),
    ]


BENCH = Bench(run, short=partial(run, n_freq=20, rounds=1))
