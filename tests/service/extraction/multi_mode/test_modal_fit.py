from dataclasses import dataclass

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.modal_fit import fit_modes, modes_at_eigenvalues
from modallab.extraction.options import Damping

LAWS = list(Damping)
FREQ: FloatArray = np.arange(20.0, 80.0, 0.5)  # wide, so that a pole held above it is fitted too
HELD = 1.5 * FREQ[-1]
FREQUENCY = np.array([30.0, 42.0, 43.0, 70.0])
LOSS_FACTOR = np.array([0.02, 0.02, 0.024, 0.03])
EIGENVALUE = (2 * np.pi * FREQUENCY) ** 2 * (1 + 1j * LOSS_FACTOR)
START = EIGENVALUE * (1 + np.array([2e-3, -1e-3, 1e-3, 2e-3]) + 4e-3j)


@dataclass(frozen=True)
class Made:
    receptance: ComplexArray  # (n_lines, n_frf)
    constant: ComplexArray  # (n_modes, n_frf)
    below: FloatArray
    above: FloatArray


def made(damping: Damping, n_frf: int = 5) -> Made:
    rng = np.random.default_rng(3)
    constant = rng.standard_normal((4, n_frf)) + 0.2j * rng.standard_normal((4, n_frf))
    below, above = rng.standard_normal(n_frf), 1e-5 * rng.standard_normal(n_frf)
    omega = 2 * np.pi * FREQ[:, None]
    natural = 2 * np.pi * FREQUENCY
    if damping is Damping.STRUCTURAL:
        modes = 1 / (EIGENVALUE - omega**2) @ constant
    else:
        zeta = LOSS_FACTOR / 2
        pole = natural * (-zeta + 1j * np.sqrt(1 - zeta**2))
        residue = constant / (2j * pole.imag[:, None])
        modes = 1 / (1j * omega - pole) @ residue + 1 / (1j * omega - pole.conj()) @ residue.conj()
    return Made(modes - below / omega**2 + above, constant, below, above)


def circular(rng: np.random.Generator, shape: tuple[int, ...]) -> ComplexArray:
    return np.asarray((rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2))


def scores(fits: list[ModalFit], truth: Made) -> tuple[FloatArray, FloatArray]:
    """Return errors over standard errors: (n, 2 n_modes) of eigenvalues, (n, n_modes, n_frf) of |A|."""
    poles = [
        np.concatenate(
            [
                (fit.frequency - FREQUENCY) / fit.frequency_error,
                (fit.loss_factor - LOSS_FACTOR) / fit.loss_factor_error,
            ]
        )
        for fit in fits
    ]
    constants = [
        (np.abs(fit.modal_constant) - np.abs(truth.constant)) / fit.modal_constant_error for fit in fits
    ]
    return np.array(poles), np.array(constants)


@pytest.mark.parametrize("damping", LAWS)
def test_modes_and_residuals_of_clean_responses_are_exact(damping: Damping) -> None:
    truth = made(damping)
    weight = 1 / np.abs(truth.receptance) ** 2
    fit = fit_modes(FREQ, truth.receptance, weight, START, damping=damping)
    # rounding, of modes a bandwidth apart
    np.testing.assert_allclose(fit.eigenvalue, EIGENVALUE, rtol=1e-11)
    np.testing.assert_allclose(fit.modal_constant, truth.constant, rtol=1e-8)
    np.testing.assert_allclose(fit.residuals[0], truth.below, rtol=1e-7)
    np.testing.assert_allclose(fit.residuals[1], truth.above, rtol=1e-7)


@pytest.mark.parametrize("damping", LAWS)
def test_standard_errors_are_the_scatter_of_repeated_tests(damping: Damping) -> None:
    truth, rng = made(damping), np.random.default_rng(1)
    size = 0.01 * np.abs(truth.receptance).max(axis=0)
    weight = np.broadcast_to(1 / size**2, truth.receptance.shape)
    fits = [
        fit_modes(FREQ, truth.receptance + size * circular(rng, weight.shape), weight, START, damping=damping)
        for _ in range(100)
    ]
    poles, constants = scores(fits, truth)
    # 100 tests give each rms to 7 %: three such of one number, one of the mean over many
    np.testing.assert_allclose(np.sqrt((poles**2).mean(axis=0)), 1.0, atol=0.25)
    assert np.sqrt((poles**2).mean()) == pytest.approx(1.0, abs=0.07)
    assert np.sqrt((constants**2).mean()) == pytest.approx(1.0, abs=0.07)
    assert max(fit.common_noise for fit in fits) < 0.1


@pytest.mark.parametrize("damping", LAWS)
def test_noise_that_all_frfs_share_is_noticed_and_widens_the_errors(damping: Damping) -> None:
    truth, rng = made(damping), np.random.default_rng(2)
    size = np.abs(truth.receptance)
    weight = 1 / (size**2 * (1e-4 + 1e-6))
    fits = []
    for _ in range(100):
        noise = 1e-2 * circular(rng, (len(FREQ), 1)) + 1e-3 * circular(rng, size.shape)
        fits.append(fit_modes(FREQ, truth.receptance * (1 + noise), weight, START, damping=damping))
    poles, constants = scores(fits, truth)
    assert np.mean([fit.common_noise for fit in fits]) == pytest.approx(1 / 1.01, abs=0.03)
    # without it the errors of five FRFs would come out 5^(1/2) times too small
    assert np.sqrt((poles**2).mean()) == pytest.approx(1.0, abs=0.1)
    # those of modal constants are a little wide: see `uncertainty`
    assert 0.8 < np.sqrt((constants**2).mean()) < 1.1


def test_covariance_is_that_of_the_whole_linearised_problem() -> None:
    truth, rng = made(Damping.STRUCTURAL, 3), np.random.default_rng(4)
    size = 0.02 * np.abs(truth.receptance) + 0.001 * np.abs(truth.receptance).max()
    noisy = truth.receptance + size * circular(rng, size.shape)
    fit = fit_modes(FREQ, noisy, 1 / size**2, START)
    x = (2 * np.pi * FREQ[:, None]) ** 2
    gap = 1 / (fit.eigenvalue - x)
    # all complex unknowns at once: four eigenvalues, then constants and residuals of one FRF after another
    rows = []
    for j in range(3):
        own = np.zeros((len(FREQ), 4 + 3 * 7), complex)
        own[:, :4] = -fit.modal_constant[:, j] * gap**2
        beside = np.concatenate([np.ones_like(x), -1 / x, 1 / ((2 * np.pi * HELD) ** 2 - x)], axis=1)
        own[:, 4 + 7 * j : 11 + 7 * j] = np.concatenate([gap, beside], axis=1)
        rows.append(own / size[:, j : j + 1])
    scale = np.linalg.norm(np.concatenate(rows), axis=0)
    whole = np.concatenate(rows) / scale
    covariance = np.linalg.inv(whole.conj().T @ whole) / np.outer(scale, scale)
    error = np.sqrt(np.diag(covariance).real / 2)  # of either part
    wide = np.maximum(fit.misfit, 1.0)
    assert fit.common_noise == 0  # of FRFs with noise of their own
    stiffness = fit.eigenvalue.real
    # the misfits of the three FRFs, within 10 % of 1, are averaged in another way here
    np.testing.assert_allclose(
        fit.frequency_error, error[:4] / (8 * np.pi**2 * fit.frequency) * np.sqrt(wide.mean()), rtol=0.03
    )
    np.testing.assert_allclose(fit.loss_factor_error, error[:4] / stiffness * np.sqrt(wide.mean()), rtol=0.03)
    np.testing.assert_allclose(
        fit.modal_constant_error.T, error[4:].reshape(3, 7)[:, :4] * np.sqrt(wide)[:, None], rtol=0.03
    )


def test_shapes_of_known_poles_are_linear_least_squares() -> None:
    truth, rng = made(Damping.STRUCTURAL), np.random.default_rng(5)
    noisy = truth.receptance * (1 + 0.05 * circular(rng, truth.receptance.shape))
    weight = rng.uniform(0.1, 1.0, noisy.shape)
    weight[:, 2] *= FREQ < 50  # half of the lines of one FRF are of no use
    fit = modes_at_eigenvalues(FREQ, noisy, weight, EIGENVALUE)
    x = (2 * np.pi * FREQ[:, None]) ** 2
    held = 1e4 / ((2 * np.pi * HELD) ** 2 - x)
    columns = np.concatenate([1 / (EIGENVALUE - x), -1e4 / x, np.ones_like(x), held], axis=1)
    for j in range(noisy.shape[1]):
        root = np.sqrt(weight[:, j])
        exact = np.linalg.lstsq(columns * root[:, None], noisy[:, j] * root, rcond=None)[0][:6]
        found = np.concatenate([fit.modal_constant[:, j], fit.residuals[:, j] / [1e4, 1]])
        np.testing.assert_allclose(found, exact, rtol=1e-6)  # squared condition of the columns
    np.testing.assert_allclose(fit.eigenvalue, EIGENVALUE, rtol=1e-14)  # turned and back


def test_dead_frfs_have_no_modes_and_disturb_nothing() -> None:
    truth, rng = made(Damping.STRUCTURAL), np.random.default_rng(6)
    size = 0.01 * np.abs(truth.receptance).max(axis=0)
    noisy = truth.receptance + size * circular(rng, truth.receptance.shape)
    weight = np.broadcast_to(1 / size**2, noisy.shape).copy()
    alone = fit_modes(FREQ, noisy[:, :4], weight[:, :4], START)
    weight[:, 4] = 0
    fit = fit_modes(FREQ, noisy, weight, START)
    np.testing.assert_allclose(fit.eigenvalue, alone.eigenvalue, rtol=1e-9)  # rounding
    assert not fit.modal_constant[:, 4].any()
    assert np.isfinite(fit.modal_constant_error).all()


@pytest.mark.parametrize("damping", LAWS)
def test_a_fit_started_with_similar_weights_ends_at_the_least_misfit_of_the_true_weights(
    damping: Damping,
) -> None:
    rng = np.random.default_rng(11)
    truth = made(damping)
    level = 0.01 * np.abs(truth.receptance).max(axis=0) * rng.uniform(0.3, 3.0, truth.receptance.shape)
    noisy = truth.receptance + level * circular(rng, level.shape)
    fit = fit_modes(FREQ, noisy, level**-2.0, START, damping=damping)
    for row in range(len(FREQUENCY)):
        for change in (1e-1, 1e-1j):  # of standard errors
            error = fit.frequency_error[row] / fit.frequency[row] * 2 * fit.eigenvalue[row].real
            moved = fit.eigenvalue.copy()
            moved[row] += change * error
            both = [
                modes_at_eigenvalues(
                    FREQ,
                    noisy,
                    level**-2.0,
                    fit.eigenvalue + sign * (moved - fit.eigenvalue),
                    damping=damping,
                ).misfit.mean()
                for sign in (-1, 0, 1)
            ]
            assert both[1] == min(both)


def test_a_pole_at_the_end_of_the_range_stays_a_residual_term() -> None:
    truth = made(Damping.STRUCTURAL)
    rng = np.random.default_rng(12)
    level = 0.01 * np.abs(truth.receptance).max(axis=0)
    noisy = truth.receptance + level * circular(rng, truth.receptance.shape)
    weight = np.broadcast_to(level**-2.0, noisy.shape)
    start = np.append(START, (2 * np.pi * FREQ[-1]) ** 2 * (1 + 0.01j))
    fit = fit_modes(FREQ, noisy, weight, start)
    assert fit.frequency[-1] > FREQ[-1] * (1 - 1e-9)  # rounding of a change of units
