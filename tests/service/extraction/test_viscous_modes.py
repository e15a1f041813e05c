"""Viscous modes at lines from 0 Hz on, in inertances made by formula without coherence."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.extract import extract
from modallab.extraction.multi_mode.modal_fit import fit_modes, fitted_receptance
from modallab.extraction.options import Damping, ExtractionOptions
from modallab.extraction.preprocessing.line_noise import line_weights
from modallab.extraction.preprocessing.responses import responses_of

FREQUENCIES = np.array([30.0, 42.0, 43.0, 70.0, 95.0, 110.0, 260.0])  # Hz, the last above the lines
DAMPING_RATIOS = np.array([0.5, 1.0, 1.2, 0.3, 2.0, 0.8, 1.0]) / 100
FREQ = np.arange(0.0, 150.1, 0.125)
N_FRF = 12


def inertance() -> ComplexArray:
    shapes = np.random.default_rng(1).standard_normal((7, N_FRF))
    omega, natural = 2 * np.pi * FREQ[:, None], 2 * np.pi * FREQUENCIES
    modes = 1 / (natural**2 - omega**2 + 2j * DAMPING_RATIOS * natural * omega)
    return np.asarray(-(omega**2) * (modes @ (shapes * shapes[:, :1])))


def noisy(decibels: float, kind: FrfKind = FrfKind.INERTANCE) -> tuple[FrfSet, FloatArray]:
    """Return FRFs with white noise of a kind so far below each FRF's rms, and its rms."""
    omega = 2 * np.pi * np.maximum(FREQ, FREQ[1])[:, None]
    exact = inertance() * (1j * omega) ** FrfKind.INERTANCE.steps_to(kind)
    rms = np.sqrt((np.abs(exact) ** 2).mean(axis=0)) * 10 ** (-decibels / 20)
    parts = np.random.default_rng(2).standard_normal((2, *exact.shape))
    values = exact + rms * (parts[0] + 1j * parts[1]) / np.sqrt(2)
    dofs = tuple(Dof(n + 1, "Z") for n in range(N_FRF))
    return FrfSet(FREQ, values[:, :, None], dofs, dofs[:1], kind), rms


def extracted(decibels: float, damping: Damping | None = None, method: str = "lscf") -> ModalModel:
    options = ExtractionOptions(damping=damping)
    return extract(noisy(decibels)[0], coherence=None, averages=100.0, method=method, options=options)


@pytest.mark.parametrize("decibels", [60, 30])
def test_viscous_modes_are_found_within_their_standard_errors(decibels: float) -> None:
    model = extracted(decibels)
    assert "viscous" in model.choices["damping"]
    assert len(model.modes) == 6
    for mode, frequency, ratio in zip(model.modes, FREQUENCIES, DAMPING_RATIOS, strict=False):
        # of twelve normal numbers one beyond 4 comes once in 1,300 such lots
        assert abs(mode.frequency - frequency) < 4 * mode.standard_errors["frequency"]
        assert abs(mode.loss_factor - 2 * ratio) < 4 * mode.standard_errors["loss_factor"]
        # bounds of Cramer and Rao at 30 dB are up to 5e-5 of the frequency, and in proportion to the noise
        assert mode.standard_errors["frequency"] / frequency < 1e-4 * 10 ** ((30 - decibels) / 20)


def test_a_fit_with_the_wrong_damping_model_is_flagged_and_one_with_the_right_one_is_not() -> None:
    wrong, right = (extracted(40, damping) for damping in Damping)
    assert all(any(flag.startswith("damping_law") for flag in mode.flags) for mode in wrong.modes)
    assert not any(flag.startswith("damping_law") for mode in right.modes for flag in mode.flags)


def test_poles_at_0_hz_are_doubtful_and_no_modes() -> None:
    for draw in range(3):
        frf, rms = noisy(30)
        rng = np.random.default_rng(draw)
        drift = rms * 10 / (1 + np.arange(len(FREQ))[:, None]) * rng.standard_normal((1, N_FRF))
        values = frf.values[:, :, 0] + drift
        drifting = FrfSet(frf.freq, values[:, :, None], frf.outputs, frf.inputs, frf.kind)
        model = extract(drifting, coherence=None, averages=100.0, method="lscf")
        assert len(model.modes) == 6
        assert all(pole.reason for pole in model.doubtful)
        # a pole may be held at the last line, within rounding of its square root
        assert all(FREQ[1] / 2 < pole.frequency < FREQ[-1] * (1 + 1e-9) for pole in model.doubtful)


@pytest.mark.parametrize("kind", list(FrfKind))
def test_noise_without_coherence_is_white_in_the_kind_in_which_it_was_added(kind: FrfKind) -> None:
    frf, rms = noisy(40, kind)
    lines = line_weights(responses_of(frf, None, 100.0)) ** -0.5  # of receptance
    factor = (2 * np.pi * FREQ[1:, None]) ** FrfKind.RECEPTANCE.steps_to(kind)
    # a quarter of 1,200 lines gives the level to 4 %; curvature near resonances adds up to a third
    np.testing.assert_allclose(lines * factor, np.tile(rms, (len(FREQ) - 1, 1)), rtol=0.4)


def test_a_viscous_pole_that_lines_do_not_determine_stays_below_critical_damping() -> None:
    responses = responses_of(noisy(60)[0], None, 100.0)
    wrong = np.ones(responses.receptance.shape)  # by far too much weight at the lowest lines
    frequency = np.append(FREQUENCIES[:6], [0.1, 180.0])
    start = np.asarray((2 * np.pi * frequency) ** 2 * (1 + 0.02j), complex)
    fit = fit_modes(responses.freq, responses.receptance, wrong, start, damping=Damping.VISCOUS)
    assert (np.abs(fit.loss_factor) < 2).all()
    assert np.isfinite(fitted_receptance(fit, responses.freq, Damping.VISCOUS)).all()


@pytest.mark.parametrize("damping", list(Damping))
def test_fitted_receptance_has_the_poles_fixed_above_the_range(damping: Damping) -> None:
    responses = responses_of(noisy(60)[0], None, 100.0)
    weight = line_weights(responses)
    start = (2 * np.pi * FREQUENCIES[:6]) ** 2 * (1 + 2j * DAMPING_RATIOS[:6])
    fit = fit_modes(responses.freq, responses.receptance, weight, start, damping=damping)
    remainder = responses.receptance - fitted_receptance(fit, responses.freq, damping)
    square = (weight * np.abs(remainder) ** 2).sum(axis=0)
    # the misfit is per line that is not used up by the 32 real unknowns of an FRF and the poles
    n_left = len(responses.freq) - 16
    np.testing.assert_allclose(square / n_left, fit.misfit, rtol=0.02)
