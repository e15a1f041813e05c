"""Noise of the force: how much of it coherence tells, and residuals freed of what they have in common."""

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.estimation.force_noise import ForceChannelNoise, decorrelated

FREQ = np.linspace(0.0, 100.0, 201)
ABOVE = FREQ > 0
RECEPTIVE = np.stack([1 / np.abs(f0**2 - FREQ**2 + 0.02j * f0**2) ** 2 for f0 in (20.0, 45.0, 80.0)], axis=1)
SIZES = 1e6 * RECEPTIVE + 1e-3  # |H|^2 of three FRFs with a resonance each


def expected(
    signal: FloatArray, noise: float, of_response: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Coherence, force and coherent power of forces with a noise and of responses with theirs, exactly."""
    force = signal + noise
    motion = SIZES * signal
    g2 = signal / force * motion / (motion + of_response)
    return g2, force, g2 * (motion + of_response)


FLAT = np.ones((201, 1))
DROPS = 1 / (1 + 20 * np.exp(-(((FREQ[:, None] - 45.0) / 2) ** 2)))  # as where a structure takes the force


@pytest.mark.parametrize("signal", [FLAT, DROPS], ids=["flat", "drops out"])
@pytest.mark.parametrize("noise", [1e-4, 1e-2, 0.3])
def test_the_force_is_freed_of_its_noise_wherever_it_drops_out(signal: FloatArray, noise: float) -> None:
    found = ForceChannelNoise.of(ABOVE, *expected(signal, noise, 1e-5))
    assert found is not None
    # exact but for 1e-6 of the faintest coherence, and the steps' end
    np.testing.assert_allclose(found.rise, np.broadcast_to(noise / signal, (201, 3)), rtol=1e-4)


def test_shares_are_the_variances_of_an_frf() -> None:
    found = ForceChannelNoise.of(ABOVE, *expected(FLAT, 1e-3, 1e-4))
    assert found is not None
    known = 1e-3 / (1e-3 + 1e-4 / SIZES)
    # what is added by the products of both noises is of their own order
    np.testing.assert_allclose(found.share, np.minimum(known, 0.95), rtol=5e-3)


def test_without_noise_of_the_force_next_to_nothing_is_shared() -> None:
    found = ForceChannelNoise.of(ABOVE, *expected(FLAT, 0.0, 1e-4))
    assert found is not None
    assert found.rise.max() < 1e-6
    assert ForceChannelNoise.of(ABOVE, *expected(FLAT, 0.0, 0.0)) is None


def test_residuals_that_share_a_number_become_independent() -> None:
    rng = np.random.default_rng(0)
    share = rng.uniform(0.0, 0.95, (4, 6))
    where = rng.uniform(size=(4, 6)) > 0.3
    for line in range(4):
        seen = np.flatnonzero(where[line])
        root = np.sqrt(share[line, seen])
        covariance = np.diag(1 - share[line, seen]) + np.outer(root, root)
        turn = np.array([decorrelated(np.tile(unit, (4, 1)), share, where)[line] for unit in np.eye(6)])
        assert not turn[:, ~where[line]].any()
        turn = turn[np.ix_(seen, seen)]
        np.testing.assert_allclose(turn.T @ covariance @ turn, np.eye(len(seen)), atol=1e-12)


def test_numbers_of_several_inputs_and_of_complex_kind_are_parted_alike() -> None:
    rng = np.random.default_rng(1)
    share, part = rng.uniform(0.0, 0.9, (3, 5, 2)), rng.standard_normal((3, 5, 2)) * (1 + 2j)
    where = np.ones(share.shape, bool)
    both = decorrelated(part, share, where)
    for k in range(2):
        alone = decorrelated(part[:, :, k].real, share[:, :, k], where[:, :, k])
        np.testing.assert_allclose(both[:, :, k], alone * (1 + 2j), rtol=1e-12)
