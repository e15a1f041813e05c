"""H1 beyond one force, and the two ends of noise."""

import numpy as np

from modallab.estimation.coherence import coherence
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.spectra import CrossSpectra


def test_h1_tells_two_correlated_forces_apart() -> None:
    rng = np.random.default_rng(3)
    records = rng.standard_normal((50, 2)) + 1j * rng.standard_normal((50, 2))
    forces = records @ np.array([[1.0, 0.6j], [0.0, 0.5]])
    h = np.array([[1 + 2j, 0.3], [-0.2j, 4.0], [0.5, 1j]])  # (n_out, n_in)
    responses = forces @ h.T
    two = CrossSpectra(
        np.array([10.0]),
        (forces.conj().T @ forces)[None, None],
        (forces.conj().T @ responses)[None, None],
        (np.abs(responses) ** 2).sum(axis=0)[None, None],
        50,
    )
    np.testing.assert_allclose(ESTIMATORS["h1"](two)[0, 0], h, rtol=1e-12)  # rounding, condition about 10
    np.testing.assert_allclose(coherence(two), 1.0, rtol=1e-12)  # the forces explain all


def test_hv_is_the_geometric_mean_of_h1_and_h2() -> None:
    noisy = CrossSpectra(
        np.array([10.0]),
        np.full((1, 1, 1, 1), 2.5 + 0j),
        np.full((1, 1, 1, 1), 3 - 1j),
        np.full((1, 1, 1), 7.0),
        10,
    )
    h1, h2, hv = (ESTIMATORS[kind](noisy) for kind in ("h1", "h2", "hv"))
    np.testing.assert_allclose(np.abs(hv) ** 2, np.abs(h1) * np.abs(h2), rtol=1e-14)  # rounding
    np.testing.assert_allclose(h1, coherence(noisy)[..., None] * h2, rtol=1e-14)  # rounding
