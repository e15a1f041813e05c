"""FRF synthesis from modes against a plain matrix product of the same size."""

import numpy as np

from benchmarks.timing import ratio
from modallab.fe.modes import ModalBasis

N_MODES, N_OUT, N_IN, N_FREQ = 234, 72, 3, 801


def run() -> list[tuple[str, float, float]]:
    """Return the time of a receptance by modal sum over that of one dgemm."""
    rng = np.random.default_rng(0)
    eigenvalues = np.linspace(1.0, 1e3, N_MODES).astype(complex) ** 2 * (1 + 0.01j)
    basis = ModalBasis(eigenvalues, rng.standard_normal((N_OUT, N_MODES)), 0)
    response = basis.at(np.linspace(1.0, 900.0, N_FREQ))
    difference, right = np.eye(N_OUT), np.eye(N_OUT)[:, :N_IN]
    a = rng.standard_normal((2 * N_FREQ, N_MODES))
    b = rng.standard_normal((N_MODES, N_OUT * N_IN))

    return [
        (
            "FRF synthesis: 234 modes x 72 x 3 x 801 lines, against dgemm",
            ratio(lambda: response.receptance(difference, right), lambda: a @ b),
            1.3,
        ),
        (
            "FRF synthesis with the modes' denominators, against dgemm",
            ratio(lambda: basis.at(response.omega).receptance(difference, right), lambda: a @ b),
            2.0,
        ),
    ]
