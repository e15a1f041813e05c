"""Errors of modes that are fitted to leaked lines of all FRFs at once."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.estimation.windows import WINDOWS
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.leakage_correction import LeakageCorrection
from modallab.extraction.multi_mode.leaked_covariance import with_leaked_errors
from modallab.extraction.multi_mode.modal_fit import fit_modes
from modallab.extraction.multi_mode.refinement import BandData, RefinedModes
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.leakage import WindowLeakage

FREQ = np.arange(60.0, 141.0)
EIGENVALUE = (2 * np.pi * np.array([80.3, 120.4])) ** 2 * (1 + 1j * np.array([0.02, 0.005]))
AVERAGES = 100.0


def stated(n_frf: int, common: float, *, noise: float = 1e-9, averages: float = AVERAGES) -> ModalFit:
    """Return two modes, 1.6 and 0.6 lines wide, in FRFs that are all alike."""
    exact = (1 / (EIGENVALUE - (2 * np.pi * FREQ[:, None]) ** 2)) @ np.ones((2, n_frf))
    weight = 1 / (np.sqrt(noise) * np.abs(exact)) ** 2
    fit = replace(fit_modes(FREQ, exact, weight, EIGENVALUE), common_noise=common)
    leakage = WindowLeakage.from_window(WINDOWS["hann"].samples(1024), "h1")
    leaked = LeakageCorrection(leakage, None, np.zeros((0, 2)), 0, averages)
    refined = RefinedModes(fit, weight, ())
    return with_leaked_errors(
        refined, BandData(FREQ, exact, weight, weights_known=True), leaked, Damping.STRUCTURAL
    )


@pytest.mark.parametrize("noise", [1e-9, 1.0])
def test_errors_in_common_do_not_fall_with_more_frfs_and_others_fall_with_their_root(noise: float) -> None:
    one, many = stated(1, 1.0, noise=noise), stated(9, 1.0, noise=noise)
    alone = stated(9, 0.0, noise=noise)
    for name in ("frequency_error", "loss_factor_error"):
        # FRFs of one size weigh alike, so that both ways the answer is exact but for rounding
        np.testing.assert_allclose(getattr(many, name), getattr(one, name), rtol=1e-6)
        np.testing.assert_allclose(getattr(alone, name), getattr(one, name) / 3, rtol=1e-6)
    np.testing.assert_allclose(many.modal_constant_error[:, 0], one.modal_constant_error[:, 0], rtol=1e-6)


def test_what_leaks_falls_with_the_root_of_the_averages() -> None:
    few, many = stated(3, 1.0), stated(3, 1.0, averages=4 * AVERAGES)
    np.testing.assert_allclose(many.frequency_error, few.frequency_error / 2, rtol=1e-6)  # no noise beside
    np.testing.assert_allclose(many.modal_constant_error, few.modal_constant_error / 2, rtol=1e-6)


def test_noise_beside_leakage_adds_to_errors() -> None:
    quiet, loud = stated(3, 0.5), stated(3, 0.5, noise=0.1)
    assert (loud.frequency_error > 1.1 * quiet.frequency_error).all()
    assert (loud.modal_constant_error > 1.1 * quiet.modal_constant_error).all()
