"""Modes 0.1 to 1.9 lines wide, driven by random noise and seen through a Hann window, read all at once."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.estimation.windows import WINDOWS
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.leakage_correction import LeakageCorrection
from modallab.extraction.multi_mode.leaked_modes import with_leakage_errors
from modallab.extraction.multi_mode.modal_fit import fit_modes
from modallab.extraction.multi_mode.refinement import BandData, RefinedModes
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.leakage import WindowLeakage
from tests.service.extraction.conftest import Beam
from tests.service.extraction.leaked_beam import WIDE, judged, of, read, taken

FREQ = np.arange(20.0, 80.0, 0.5)
FREQUENCY, LOSS_FACTOR = np.array([35.2, 60.1]), np.array([0.02, 0.005])  # 1.4 and 0.6 lines wide
EIGENVALUE = (2 * np.pi * FREQUENCY) ** 2 * (1 + 1j * LOSS_FACTOR)
NOISE = 1e-3  # over the FRF
HANN = WINDOWS["hann"].samples(1024)


@pytest.mark.parametrize("estimator", ["h1", "h2"])
def test_modes_beyond_their_stated_errors_are_flagged(estimator: str, plain_beam: Beam) -> None:
    off, flagged = judged(estimator, "lscf", of(plain_beam))
    # 48 modes and two numbers each: chance alone puts one beyond 3 in four lots, beyond 3.5 in 22
    assert not ((off > 3.5) & ~flagged).any()


@pytest.mark.parametrize("estimator", ["h1", "h2"])
def test_modes_that_the_lines_tell_are_not_flagged(estimator: str, plain_beam: Beam) -> None:
    off, flagged = judged(estimator, "lscf", of(plain_beam))
    assert not flagged[:, WIDE].any()
    assert np.isfinite(off[:, WIDE]).all()


@pytest.mark.parametrize("estimator", ["h1", "h2"])
def test_all_frfs_together_tell_wide_modes_better_than_those_that_cleaned_their_lines(estimator: str) -> None:
    # those are of Dobson's method, which says the same of them when asked by itself. Of a test with records,
    # in which all channels leak alike: of drawn ones, which leak each by itself, a mean is nearly as good
    alone, joint = (read(taken(estimator)[-1], estimator, method) for method in ("dobson", "lscf"))
    for cleaner, mode in zip(alone.modes[WIDE], joint.modes[-5:], strict=True):
        for name, error in cleaner.standard_errors.items():
            # 0.38 to 0.70 here; of independent FRFs it would be 0.3, one over the root of eleven
            assert mode.standard_errors[name] < 0.75 * error


@pytest.mark.parametrize("estimator", ["h1", "h2"])
def test_standard_errors_of_leaked_modes_are_of_the_size_of_what_they_are_off_by(
    estimator: str, plain_beam: Beam
) -> None:
    off, flagged = judged(estimator, "lscf", of(plain_beam))
    seen = off[~flagged]
    # the larger of two normal numbers is 1.16 rms; 38 and more of them tell that to a tenth. Lines of drawn
    # tests are independent, so that errors which allow for a window's likeness are a third too wide there
    assert 0.5 < np.sqrt((seen**2).mean()) < 1.5


def test_noise_of_the_force_does_not_lower_modal_constants_where_lines_leak(plain_beam: Beam) -> None:
    scores = []
    for measurement in taken("h1"):
        model = read(measurement, "h1", "lscf")
        assert model.modal_constant is not None
        exact = np.abs(plain_beam.constants[WIDE])
        scores.append(np.median(np.abs(model.modal_constant[-5:]) / exact) - 1)
    # noise of 1 % of the force's power would make it -0.01; leakage on flanks is told from it to a tenth
    assert np.abs(np.mean(scores)) < 0.002


def fitted() -> tuple[RefinedModes, BandData]:
    """Return two modes in three FRFs, and their lines, which do not leak."""
    rng = np.random.default_rng(1)
    exact = (1 / (EIGENVALUE - (2 * np.pi * FREQ[:, None]) ** 2)) @ rng.uniform(0.5, 1.5, (2, 3))
    error = rng.standard_normal((2, *exact.shape)) * NOISE / np.sqrt(2)
    receptance = exact * (1 + error[0] + 1j * error[1])
    weight = 1 / (NOISE * np.abs(exact)) ** 2
    stretch = BandData(FREQ, receptance, weight, weights_known=True)
    return RefinedModes(fit_modes(FREQ, receptance, weight, EIGENVALUE), weight, ()), stretch


def vaguer(fit: ModalFit, by: float) -> ModalFit:
    """Return the same modes with larger errors."""
    return replace(
        fit,
        eigenvalue_covariance=by**2 * fit.eigenvalue_covariance,
        modal_constant_error=by * fit.modal_constant_error,
    )


def test_modes_share_errors_and_bias_of_those_that_cleaned_their_lines() -> None:
    refined, stretch = fitted()
    bias = np.array([[0.02, 0.0005], [0.01, 0.0002]])
    leaked = LeakageCorrection(WindowLeakage.from_window(HANN, "h1"), vaguer(refined.fit, 5.0), bias, drive=0)
    surer = replace(leaked, modes=vaguer(refined.fit, 1e-6), bias=0 * bias)
    alone, out = (with_leakage_errors(refined, stretch, by, Damping.STRUCTURAL) for by in (surer, leaked))
    # a Hann window makes errors of lines alike: (35/128)/(3/8)^2 times the variance
    np.testing.assert_allclose(
        alone.fit.eigenvalue_covariance, 35 / 18 * refined.fit.eigenvalue_covariance, rtol=1e-3
    )
    for name in ("frequency_error", "loss_factor_error", "modal_constant_error"):
        own, wider = getattr(alone.fit, name), getattr(out.fit, name)
        assert (wider > 1.02 * own).any()
        assert (wider >= own).all()
    assert out.leakage_bias is not None
    assert alone.leakage_bias is not None
    assert (out.leakage_bias >= alone.leakage_bias).all()
    twice = replace(leaked, bias=1e3 * bias)
    more = with_leakage_errors(refined, stretch, twice, Damping.STRUCTURAL).leakage_bias
    assert more is not None
    assert (more > out.leakage_bias).all()


def test_a_cleaner_too_vague_to_follow_hands_on_its_own_error_and_bias() -> None:
    refined, stretch = fitted()
    fit, bias = refined.fit, np.array([[0.2, 0.01], [0.1, 0.02]])
    known = vaguer(fit, 0.5 / float((fit.loss_factor_error / fit.loss_factor).min()))
    leaked = LeakageCorrection(WindowLeakage.from_window(HANN, "h1"), known, bias, drive=0)
    out = with_leakage_errors(refined, stretch, leaked, Damping.STRUCTURAL)
    # an error equal to its own is the root of a sum of squares: a few units of its last digit
    rounding = 1 - 4 * np.finfo(float).eps
    assert (out.fit.frequency_error >= rounding * known.frequency_error).all()
    assert (out.fit.loss_factor_error >= rounding * known.loss_factor_error).all()
    assert (out.fit.modal_constant_error >= known.modal_constant_error).all()
    assert out.leakage_bias is not None
    np.testing.assert_allclose(out.leakage_bias, bias)


@pytest.mark.parametrize("none", [True, False])
def test_a_mode_whose_lines_no_mode_has_cleaned_may_be_off_by_all_its_leakage(none: bool) -> None:
    refined, stretch = fitted()
    fit = refined.fit
    first = ModalFit(
        fit.eigenvalue[:1],
        fit.modal_constant[:1],
        fit.residuals,
        fit.eigenvalue_covariance[::2, ::2],
        fit.modal_constant_error[:1],
        fit.misfit,
    )
    leaked = LeakageCorrection(
        WindowLeakage.from_window(HANN, "h1"), None if none else first, np.zeros((1 - none, 2)), drive=0
    )
    bias = with_leakage_errors(refined, stretch, leaked, Damping.STRUCTURAL).leakage_bias
    assert bias is not None
    # half a line in frequency; a line's width of damping is more than the second mode has
    np.testing.assert_allclose(bias[1], [0.25, fit.loss_factor[1]])
    if none:
        np.testing.assert_allclose(bias[0], [0.25, 0.5 / fit.frequency[0]])
    else:
        assert (bias[0] < 0.05 * np.array([0.25, fit.loss_factor[0]])).all()
