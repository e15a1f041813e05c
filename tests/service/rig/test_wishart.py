"""Draws follow the law of averaged Gaussian records."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.averaging_scatter import printed as printed_errors
from benchmarks.averaging_scatter import simulate_wishart as drawn_scatter
from benchmarks.averaging_scatter import simulated as simulated_scatter
from benchmarks.drawn_against_sampled import bench, compare
from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.progress import silent
from modallab.estimation.coherence import coherence, coherence_error, frf_error
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Noise
from modallab.rig.measure import draw
from modallab.rig.sampled import sampled_spectra
from modallab.rig.wishart import wishart_spectra
from tests.rigs import beam_system, rig

N_TESTS = 20_000


def expected(averages: float = 50, g2: float = 0.7, n_out: int = 1) -> CrossSpectra:
    """One run at 0 Hz and two lines above, all of one coherence."""
    h = np.tile(np.array([2.0, 1 - 2j, -0.3j])[None, :, None, None], n_out)
    return CrossSpectra(
        np.array([0.0, 1.0, 2.0]),
        np.full((1, 3, 1, 1), 4.0 + 0j),
        np.asarray(4 * h, complex),
        4 * np.abs(h[:, :, 0]) ** 2 / g2,
        averages,
    )


def test_spectra_scatter_about_the_expected_ones_as_chi_square_of_twice_the_averages() -> None:
    whole = expected()
    drawn = wishart_spectra(whole, np.random.default_rng(1), N_TESTS)
    for found, mean in ((drawn.ff[..., 0].real, whole.ff[..., 0].real), (drawn.xx, whole.xx)):
        ratio = (found / mean)[..., 0]
        degrees = np.array([50, 100, 100])  # half as many at 0 Hz, where the transform is real
        variance = 2 / degrees
        # of a mean over the tests, and of a variance of nearly normal numbers: four of each
        np.testing.assert_allclose(ratio.mean(axis=0), 1, atol=4 * np.sqrt(variance.max() / N_TESTS))
        np.testing.assert_allclose(ratio.var(axis=0), variance, rtol=4 * np.sqrt(2.3 / N_TESTS))


@pytest.mark.parametrize("g2", [0.4, 0.7, 0.95])
def test_random_errors_are_those_printed(g2: float) -> None:
    n_d = 400.0  # the printed forms are of first order in 1/n_d
    whole = expected(n_d, g2)
    drawn = wishart_spectra(whole, np.random.default_rng(2), N_TESTS)
    ratio = (ESTIMATORS["h1"](drawn) / ESTIMATORS["h1"](whole))[:, 1:, 0, 0]
    found = coherence(drawn)[:, 1:, 0]
    error = frf_error(np.array(g2), n_d)
    # 1992 thesis, eq. [5.16] to [5.19]; 2/n_d of the next order and 4/sqrt(2 tests) of scatter
    margin = 2 / n_d + 4 / np.sqrt(2 * N_TESTS)
    np.testing.assert_allclose(np.abs(ratio).std(axis=0), error, rtol=margin)
    np.testing.assert_allclose(np.angle(ratio).std(axis=0), np.arcsin(error), rtol=margin)
    np.testing.assert_allclose((found / g2).std(axis=0), coherence_error(np.array(g2), n_d), rtol=margin)


@pytest.mark.parametrize("averages", [30, 100])
def test_at_thirty_averages_and_more_the_errors_are_those_printed_within_five_per_cent(averages: int) -> None:
    found = drawn_scatter(averages, seed=1).errors
    # What the printed forms leave out is of relative order 1/n_d: 3.5 % at most at 30, 0.9 % at 100.
    np.testing.assert_allclose(found, printed_errors(averages), rtol=0.05)


def test_at_ten_averages_the_errors_are_those_of_averaged_gaussian_pairs() -> None:
    found, wanted = drawn_scatter(10, seed=1), simulated_scatter(10, seed=2)
    # 200,000 of each: both deviations are known to 0.2 to 0.4 % (the coherence's tails are long)
    np.testing.assert_allclose(found.errors, wanted.errors, rtol=0.01)
    # The means, the bias of few averages among them: four standard errors of the difference.
    apart = np.abs(found.mean_coherence / wanted.mean_coherence - 1)
    assert (apart < 4 * wanted.coherence * np.sqrt(2 / 200_000)).all()
    # The printed forms are up to 11 % off here: whoever drew by them would fail.
    assert np.abs(wanted.errors / printed_errors(10) - 1).max() > 0.1


def test_a_complex_residual_has_twice_the_squared_error_of_its_size() -> None:
    whole = expected(400.0, 0.7)
    drawn = wishart_spectra(whole, np.random.default_rng(3), N_TESTS)
    residual = np.log(ESTIMATORS["h1"](drawn) / ESTIMATORS["h1"](whole))[:, 1:, 0, 0]
    wanted = 2 * frf_error(np.array(0.7), 400.0) ** 2
    assert np.isclose((np.abs(residual) ** 2).mean(), wanted, rtol=2 / 400 + 4 / np.sqrt(N_TESTS))


def test_at_zero_hertz_spectra_are_real() -> None:
    drawn = wishart_spectra(expected(), np.random.default_rng(4), 10)
    assert (drawn.fx[:, 0].imag == 0).all()
    assert (drawn.fx[:, 1:].imag != 0).all()


def test_one_average_explains_all() -> None:
    drawn = wishart_spectra(expected(averages=1, g2=0.3), np.random.default_rng(5), 10)
    np.testing.assert_allclose(coherence(drawn), 1.0, rtol=1e-12)  # rounding


def test_without_noise_the_frf_comes_through_a_random_force() -> None:
    whole = expected_spectra(chain(beam_system(), rig(1, 7)))
    drawn = wishart_spectra(whole, np.random.default_rng(6))
    # what a full coherence leaves of the response is rounding, 1e-16 in power: 1e-8 in the FRF
    np.testing.assert_allclose(ESTIMATORS["h1"](drawn), ESTIMATORS["h1"](whole), rtol=1e-7)
    assert np.abs(drawn.ff / whole.ff - 1).max() > 0.1


def test_channels_of_a_run_share_the_force_and_runs_do_not() -> None:
    two = expected(n_out=2)
    drawn = wishart_spectra(two, np.random.default_rng(7), N_TESTS)
    assert drawn.ff.shape == (N_TESTS, 3, 1, 1)
    first, second = drawn.xx[:, 1].T
    both = np.corrcoef(first, second)[0, 1]
    # each response's power is 0.7 of the force's, squared as a correlation; three errors of N_TESTS
    assert np.isclose(both, 0.7**2, atol=3 / np.sqrt(N_TESTS))
    other = np.corrcoef(drawn.ff[1:, 1, 0, 0].real, drawn.ff[:-1, 1, 0, 0].real)[0, 1]
    assert abs(other) < 3 / np.sqrt(N_TESTS)


def test_channels_of_a_run_share_the_noise_of_the_force() -> None:
    n, signal, noise, own = 20, 4.0, 1.5, np.array([0.1, 1.0])
    h = np.array([[2.0, 0.7], [1 - 2j, 1j], [-0.3j, 0.5]])
    power = np.abs(h) ** 2 * signal
    whole = CrossSpectra(
        np.array([0.0, 1.0, 2.0]),
        np.full((1, 3, 1, 1), signal + noise + 0j),
        np.asarray(h * signal, complex)[None, :, None],
        (power + own)[None],
        n,
    )
    rng = np.random.default_rng(8)
    drawn = wishart_spectra(whole, rng, N_TESTS, signal=np.full((1, 3), signal))

    def normal(variance: float | FloatArray, width: int) -> ComplexArray:
        parts = rng.standard_normal((N_TESTS, n, 3, width, 2)).view(complex)[..., 0] / np.sqrt(2)
        parts[:, :, 0] = parts[:, :, 0].real * np.sqrt(2)
        return np.asarray(np.sqrt(variance) * parts)

    force = normal(signal, 1)  # records, averaged: the law itself
    response = h * force + normal(own, 2)
    force = force + normal(noise, 1)
    records = ((np.abs(force) ** 2), force.conj() * response, np.abs(response) ** 2)
    found = [drawn.ff[..., 0], drawn.fx[:, :, 0], drawn.xx]
    for line in range(3):
        law, told = (
            np.concatenate([part[:, line].astype(complex) for part in parts], axis=1).view(float)
            for parts in ([part.mean(axis=1) for part in records], found)
        )
        # means and products of two samples of nearly normal numbers, in units of their scatter: four errors
        width = np.sqrt(law.var(axis=0)) + 1e-12
        assert np.abs((told - law).mean(axis=0) / width).max() < 4 * np.sqrt(2 / N_TESTS)
        apart = np.cov((told / width).T) - np.cov((law / width).T)
        assert np.abs(apart).max() < 4 * np.sqrt(2 * 2.3 / N_TESTS)


def test_drawn_and_sampled_channels_move_alike_by_noise_of_the_force() -> None:
    setup = rig(1, 4, 7, noise=Noise(1e-2, 1e-5))
    setup = replace(setup, accelerometers=replace(setup.accelerometers, roving=False))
    whole = chain(beam_system(), setup)
    endless = expected_spectra(whole)
    exact = ESTIMATORS["h1"](endless)[0, 1:, :, 0]
    error = frf_error(coherence(endless)[0, 1:], endless.averages)
    rng = np.random.default_rng(9)
    ties = []
    for spectra in (draw(whole, rng), sampled_spectra(whole, rng, silent)):
        off = np.log(ESTIMATORS["h1"](spectra)[0, 1:, :, 0] / exact) / error
        ties.append((off.conj()[:, 0] * off[:, 1]).real.mean() / 2)
    # noise of the force is some nine tenths of their noise; 400 lines: 0.05 each, three of the difference
    assert min(ties) > 0.7
    assert abs(ties[0] - ties[1]) < 0.2


def test_the_same_seed_draws_the_same_bytes() -> None:
    whole = expected_spectra(chain(beam_system(), rig(1, 7, noise=Noise(1e-2, 1e-3))))
    a, b, c = (wishart_spectra(whole, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert a.fx.tobytes() == b.fx.tobytes() != c.fx.tobytes()
    assert a.xx.tobytes() == b.xx.tobytes()


def test_drawn_and_sampled_estimates_have_one_mean_and_one_variance() -> None:
    whole = bench("periodic_random", "rectangular", n_lines=33, n_out=4)
    for name, z in compare(whole, n_tests=1000, seed=3).items():
        # z of 128 lines: its standard deviation is known to 1/sqrt(256); two and a half of these
        assert abs(z.std() - 1) < 2.5 / np.sqrt(2 * 128), name
        assert abs(z.mean()) < 3.5 / np.sqrt(128), name
