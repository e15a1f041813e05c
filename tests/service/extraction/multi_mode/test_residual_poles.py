"""Poles that only the residual of a fit shows."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.estimation.windows import WINDOWS
from modallab.extraction.extract import extract
from modallab.extraction.multi_mode.modal_fit import fitted_receptance, modes_at_eigenvalues
from modallab.extraction.multi_mode.refinement import BandData
from modallab.extraction.multi_mode.residual_poles import Candidates, residual_poles
from modallab.extraction.multi_mode.residual_search import doubling
from modallab.extraction.options import Damping

FREQ = np.arange(20.0, 120.0, 0.125)
FREQUENCIES, LOSS_FACTORS = np.array([40.0, 42.0, 90.0]), np.array([0.02, 0.024, 0.01])
N_FRF = 6


def eigenvalues(frequency: FloatArray) -> ComplexArray:
    return np.asarray((2 * np.pi * frequency) ** 2 * (1 + 1j * LOSS_FACTORS[: len(frequency)]))


def receptance(constant: FloatArray) -> ComplexArray:
    poles = 1 / (eigenvalues(FREQUENCIES) - (2 * np.pi * FREQ[:, None]) ** 2)
    return np.asarray(poles @ constant)


def band_data(values: ComplexArray, noise: float, seed: int, n_ref: int = 1) -> BandData:
    parts = np.random.default_rng([7, seed]).standard_normal((2, *values.shape))
    noisy = values + noise * (parts[0] + 1j * parts[1]) / np.sqrt(2)
    return BandData(FREQ, noisy, np.full(values.shape, noise**-2.0), True, n_ref)


def candidates_beside(band: BandData, known: FloatArray) -> Candidates | None:
    """Return the poles that the residual of a fit of known frequencies shows."""
    start = np.asarray((2 * np.pi * known) ** 2 * (1 + 0.02j), complex)
    fit = modes_at_eigenvalues(band.freq, band.receptance, band.weight, start)
    return residual_poles(band, band.receptance - fitted_receptance(fit, band.freq, Damping.STRUCTURAL), fit)


@pytest.mark.parametrize("seed", range(10))
def test_noise_alone_shows_no_pole(seed: int) -> None:
    band = band_data(np.zeros((len(FREQ), N_FRF), complex), 1e-6, seed)
    # wrong once in 1e5 such lots: the probability of a false pole anywhere is 1e-6
    assert candidates_beside(band, np.array([40.0])) is None


@pytest.mark.parametrize("seed", range(3))
def test_noise_that_a_window_correlates_shows_no_pole(seed: int) -> None:
    rng, n = np.random.default_rng([8, seed]), 4096
    records = rng.standard_normal((N_FRF, n)) * WINDOWS["exponential"].samples(n)
    noise = np.fft.rfft(records)[:, 100 : 100 + len(FREQ)].T
    noise *= 1e-6 / np.sqrt((np.abs(noise) ** 2).mean())
    band = BandData(FREQ, noise, np.full(noise.shape, 1e12), True)
    assert candidates_beside(band, np.array([40.0])) is None


@pytest.mark.parametrize("n_ref", [1, 2])
def test_a_weak_mode_is_found_in_noise_a_third_of_its_peak_high(n_ref: int) -> None:
    shapes = np.random.default_rng(1).standard_normal((3, N_FRF // n_ref, 1))
    driven = np.random.default_rng(2).uniform(0.5, 1.5, (3, 1, n_ref))
    constant = (shapes * driven).reshape(3, N_FRF)
    constant[2] *= 0.05
    values = receptance(constant)
    peak = np.abs(values[FREQ == 90.0]).max()
    found = candidates_beside(band_data(values, 0.3 * peak, 0, n_ref), FREQUENCIES[:2])
    assert found is not None
    nearest = int(np.abs(found.frequency - 90.0).argmin())
    # the bandwidth is 0.9 Hz, and the pole only starts a fit
    assert abs(found.frequency[nearest] - 90.0) < 0.3
    if n_ref > 1:
        assert found.participation is not None
        ratio = found.participation[nearest, 1] / found.participation[nearest, 0]
        exact = driven[2, 0, 1] / driven[2, 0, 0]
        # seven lines in three DoFs, at signal-to-noise ratios up to three, give the ratio to a tenth
        assert abs(ratio - exact) < 0.4


def inertances(values: ComplexArray) -> FrfSet:
    dofs = tuple(Dof(n + 1, "Z") for n in range(values.shape[1]))
    return FrfSet(
        FREQ,
        -((2 * np.pi * FREQ[:, None, None]) ** 2) * values[:, :, None],
        dofs,
        dofs[:1],
        FrfKind.INERTANCE,
    )


def test_both_modes_of_a_pair_are_found_where_one_is_weak_in_every_frf() -> None:
    shapes = np.random.default_rng(3).standard_normal((3, 12))
    constant = shapes * shapes[:, :1]
    constant[1] *= 0.05
    band = band_data(receptance(constant), 1e-2 * np.abs(receptance(constant)).std(), 1)
    model = extract(inertances(band.receptance), coherence=None, averages=1.0, method="lscf")
    # half a per cent of the frequency is a quarter of the pair's distance
    np.testing.assert_allclose(model.frequencies, FREQUENCIES, rtol=5e-3)


def test_a_mode_that_drifts_from_frf_to_frf_is_not_split_by_the_search() -> None:
    rng = np.random.default_rng(4)
    shift = 1 + 1e-3 * np.linspace(-0.5, 0.5, 12)  # a tenth of a bandwidth from the first FRF to the last
    constant = rng.uniform(0.5, 1.5, (3, 12))
    natural = 2 * np.pi * np.array([30.0, 55.0, 90.0])
    poles = (natural[:, None] * shift) ** 2 * (1 + 0.01j)
    values = (constant / (poles - (2 * np.pi * FREQ[:, None, None]) ** 2)).sum(axis=1)
    band = band_data(values, 1e-2 * float(np.abs(values).std()), 2)
    model = extract(inertances(band.receptance), coherence=None, averages=1.0, method="lscf")
    assert np.count_nonzero(np.abs(model.frequencies - 90.0) < 5.0) == 1


def test_a_broad_pole_of_the_search_does_not_hide_a_mode() -> None:
    fit = modes_at_eigenvalues(
        FREQ,
        np.zeros((len(FREQ), 2), complex),
        np.ones((len(FREQ), 2)),
        np.asarray((2 * np.pi * np.array([40.0, 42.0, 44.0])) ** 2 * (1 + 1j * np.array([0.01, 0.01, 0.5]))),
    )
    before = modes_at_eigenvalues(
        FREQ,
        np.zeros((len(FREQ), 2), complex),
        np.ones((len(FREQ), 2)),
        np.array([(2 * np.pi * 40.0) ** 2 * (1 + 0.01j)]),
    )
    found = Candidates(np.array([(2 * np.pi * 42.0) ** 2 * (1 + 0.01j)]), None)
    assert not doubling(before, fit, found, FREQ).any()
