import numpy as np
import pytest

from modallab.extraction.single_mode.method import EXTRACTION_METHODS, ModeFit


def test_the_damping_carpet_is_flat_for_one_mode_and_rises_with_noise() -> None:
    freq = np.tile(np.arange(94.0, 107.0), (2, 1))
    frf = ModeFit(100.4, 0.02, 1.0 + 0.1j).response(freq)
    rng = np.random.default_rng(0)
    frf[1] *= 1 + 0.01 * (rng.standard_normal(13) + 1j * rng.standard_normal(13))
    fits = EXTRACTION_METHODS["circle_fit"](freq, frf, 1 / np.abs(frf) ** 2)
    radius, damping = fits.quality["radius_variation"], fits.quality["damping_variation"]
    assert radius[0] == pytest.approx(0, abs=1e-6)  # %, rounding
    assert damping[0] == pytest.approx(0, abs=1e-6)
    # 1 % on each line shows as about 1 % in both; a factor of three either way is the scatter of 13 lines
    assert 0.3 < radius[1] < 3
    assert 0.3 < damping[1] < 6


def test_the_phase_of_the_diameter_is_that_of_the_modal_constant() -> None:
    freq = np.tile(np.arange(94.0, 107.0), (4, 1))
    constants = np.exp(1j * np.array([0.0, 0.5, 1.5, 3.0]))
    frf = np.array([ModeFit(100.4, 0.02, complex(c)).response(freq[0]) for c in constants])
    fits = EXTRACTION_METHODS["circle_fit"](freq, frf, np.ones(frf.shape))
    np.testing.assert_allclose(fits.modal_constant, constants, rtol=1e-9)  # rounding through the fit
