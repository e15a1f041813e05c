import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.extraction.single_mode.method import EXTRACTION_METHODS, ModeFit
from modallab.extraction.single_mode.methods.circle_fit import CircleFitOptions


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


def test_an_arc_about_resonance_keeps_a_neighbouring_mode_out() -> None:
    freq = np.arange(90.0, 111.0, 0.5)[None]
    mode, neighbour = ModeFit(100.4, 0.02, 1.0 + 0.1j), ModeFit(115.0, 0.02, 1.0 + 0j)
    frf = mode.response(freq) + neighbour.response(freq)
    weight = np.ones(frf.shape)
    circle_fit = EXTRACTION_METHODS["circle_fit"]
    whole, arc = (
        circle_fit.with_options(CircleFitOptions(arc=arc))(freq, frf, weight) for arc in (None, 240.0)
    )
    errors = [abs(float(fits.loss_factor[0]) - mode.loss_factor) for fits in (whole, arc)]
    assert errors[1] < errors[0] / 2
    drawn = circle_fit.plot_with_options(CircleFitOptions(arc=240.0))(freq[0], frf[0], weight[0])
    assert np.abs(drawn["angle"]).max() < np.radians(130)  # the second fit turns its resonance a little
    np.testing.assert_array_equal(circle_fit(freq, frf, weight).frequency, whole.frequency)


def test_an_arc_finds_one_mode_exactly_and_few_lines_keep_all() -> None:
    freq = np.tile(np.arange(94.0, 107.0), (2, 1))
    frf = np.array([ModeFit(100.4, eta, 1.0 + 0.1j).response(freq[0]) for eta in (0.05, 1e-4)])
    fit = EXTRACTION_METHODS["circle_fit"].with_options(CircleFitOptions(arc=270.0))
    fits = fit(freq, frf, np.ones(frf.shape))  # of the lighter mode no four lines lie on the arc
    np.testing.assert_allclose(fits.frequency, 100.4, rtol=1e-9)  # rounding through the fit
    with pytest.raises(InvalidInputError, match="arc is out of bounds"):
        CircleFitOptions(arc=30.0)
