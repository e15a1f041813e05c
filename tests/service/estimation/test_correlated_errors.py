"""Errors of FRFs to several forces: their correlation from the noises, and none after its removal."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.correlated_errors import CorrelatedErrors, IncoherentShares, white_noises

N_LINES, N_OUT, N_IN = 40, 3, 2
FORCE_NOISE, RESPONSE_NOISE = np.array([0.04, 0.01]), np.array([0.02, 0.3, 0.05])
FORCES = np.array([[1.0, 0.5 + 0.2j], [0.5 - 0.2j, 0.8]])
COLUMNS = np.array([[0, 3], [1, 4], [2, 5]])


def circular(rng: np.random.Generator, *shape: int) -> ComplexArray:
    return np.asarray((rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2))


def frfs() -> ComplexArray:
    return circular(np.random.default_rng(1), N_LINES, N_OUT, N_IN) + 0.2


def incoherent(h: ComplexArray) -> FloatArray:
    return np.asarray(np.abs(h) ** 2 @ FORCE_NOISE + RESPONSE_NOISE)


def drawn_errors(h: ComplexArray, n_tests: int) -> ComplexArray:
    """Relative errors of H1 over their standard deviation, (n_tests, n_lines, n_out, n_in)."""
    rng = np.random.default_rng(2)
    root = np.linalg.cholesky(np.linalg.inv(FORCES))
    force = circular(rng, n_tests, N_LINES, N_IN, N_IN) * np.sqrt(FORCE_NOISE)[:, None]
    own = circular(rng, n_tests, N_LINES, N_OUT, N_IN) * np.sqrt(RESPONSE_NOISE)[:, None]
    error = (h @ force + own) @ root.T
    size = np.sqrt(incoherent(h)[..., None] * np.diag(np.linalg.inv(FORCES)).real)
    return np.asarray(error / size * np.abs(h) / h)


def covariance(errors: ComplexArray) -> ComplexArray:
    """Covariance (n_lines, n, n) of errors (n_tests, n_lines, n)."""
    return np.asarray(np.einsum("tfi,tfj->fij", errors, errors.conj()) / len(errors))


def exact() -> tuple[ComplexArray, CorrelatedErrors]:
    h = frfs()
    shares = IncoherentShares(h * np.sqrt(FORCE_NOISE / incoherent(h)[..., None]))
    forces = np.repeat(FORCES[None], N_LINES, axis=0)
    return h, shares.of_frfs(h, forces, np.ones(h.shape), COLUMNS)


def test_decorrelated_errors_are_independent_and_of_unit_variance() -> None:
    h, correlated = exact()
    errors = np.zeros((4000, N_LINES, 6), complex)
    errors[..., COLUMNS] = drawn_errors(h, 4000)
    used = np.ones((N_LINES, 6), bool)
    before, after = covariance(errors), covariance(correlated.decorrelated(errors, used))
    assert np.abs(before - np.eye(6)).max() > 0.5
    # 4000 draws tell a correlation to 1/sqrt(4000) = 1.6 %: five of them for the worst of 1400 numbers
    np.testing.assert_allclose(after, np.broadcast_to(np.eye(6), after.shape), atol=0.08)


def test_errors_that_are_not_used_take_no_part() -> None:
    h, correlated = exact()
    errors = np.zeros((4000, N_LINES, 6), complex)
    errors[..., COLUMNS] = drawn_errors(h, 4000)
    used = np.ones((N_LINES, 6), bool)
    used[:, [0, 2]] = False
    errors[:, ~used] = np.nan
    after = correlated.decorrelated(errors, used)
    assert not after[:, ~used].any()
    kept = covariance(after[..., [1, 3, 4, 5]])
    np.testing.assert_allclose(kept, np.broadcast_to(np.eye(4), kept.shape), atol=0.08)  # as above


def test_errors_that_coherence_does_not_tell_are_independent() -> None:
    h = frfs()
    shares = IncoherentShares(h * np.sqrt(FORCE_NOISE / incoherent(h)[..., None]))
    correlated = shares.of_frfs(h, np.repeat(FORCES[None], N_LINES, axis=0), np.zeros(h.shape), COLUMNS)
    errors = circular(np.random.default_rng(3), N_LINES, 6)
    np.testing.assert_allclose(
        correlated.decorrelated(errors, np.ones((N_LINES, 6), bool)), errors, rtol=1e-12
    )


def test_incoherent_spectra_are_as_correlated_as_they_are_coherent() -> None:
    """Logarithms of averages of two records have the coherence of the records as their correlation."""
    h, rng, n_tests, n = frfs()[:5], np.random.default_rng(4), 4000, 30
    noise = circular(rng, n_tests, n, 5, N_IN) * np.sqrt(FORCE_NOISE)
    own = circular(rng, n_tests, n, 5, N_OUT) * np.sqrt(RESPONSE_NOISE)
    powers = np.log((np.abs(np.einsum("foi,tnfi->tnfo", h, noise) + own) ** 2).mean(axis=1))
    powers = (powers - powers.mean(axis=0)) / powers.std(axis=0)
    shares = IncoherentShares(h * np.sqrt(FORCE_NOISE / incoherent(h)[..., None]))
    correlated = shares.of_responses(np.arange(N_OUT))
    after = covariance(correlated.decorrelated(powers.astype(complex), np.ones((5, N_OUT), bool)))
    # as above; logarithms of 30 averages are nearly as correlated as the averages
    np.testing.assert_allclose(after, np.broadcast_to(np.eye(N_OUT), after.shape), atol=0.1)


@pytest.mark.parametrize("force_noise", [FORCE_NOISE, np.zeros(2), np.array([0.04, 0.0])])
def test_white_noises_are_told_apart_by_the_frfs(force_noise: FloatArray) -> None:
    h = circular(np.random.default_rng(5), 400, N_OUT, N_IN)
    gain, rng = np.abs(h) ** 2, np.random.default_rng(6)
    power = (gain @ force_noise + RESPONSE_NOISE) * rng.standard_gamma(30, (400, N_OUT)) / 30
    power[7] *= 50  # a line with leakage
    force, response = white_noises(power, gain)
    # 400 lines of 30 averages: 1 % for what makes up half of the power, 3 % where it is a tenth
    np.testing.assert_allclose(response, RESPONSE_NOISE, rtol=0.1)
    np.testing.assert_allclose(force, force_noise, rtol=0.1, atol=0.003)
