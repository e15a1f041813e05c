"""Modes 0.1 to 1.9 lines wide, driven by random noise and seen through a Hann window, read all at once."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.estimation.windows import WINDOWS
from modallab.extraction.jointly.fitted import ModalFit
from modallab.extraction.jointly.leaked_modes import allowing_for_leakage
from modallab.extraction.jointly.modal_fit import fit_modes
from modallab.extraction.jointly.refinement import Refined, Stretch
from modallab.extraction.jointly.unleaked import Leaked
from modallab.extraction.measured.leakage import Leakage
from modallab.extraction.options import Damping
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


def test_no_mode_is_surer_than_the_one_that_cleaned_its_lines() -> None:
    # those are of Dobson's method, which says the same of them when asked by itself
    alone, joint = (read(taken("h2")[0], "h2", method) for method in ("dobson", "lscf"))
    for cleaner in alone.modes:
        mode = min(joint.modes, key=lambda mode: abs(mode.frequency - cleaner.frequency))
        for name, error in cleaner.standard_errors.items():
            assert mode.standard_errors[name] >= error * (1 - 1e-9)  # rounding
            assert mode.leakage_bias[name] >= cleaner.leakage_bias[name]


def fitted() -> tuple[Refined, Stretch]:
    """Return two modes in three FRFs, and their lines, which do not leak."""
    rng = np.random.default_rng(1)
    exact = (1 / (EIGENVALUE - (2 * np.pi * FREQ[:, None]) ** 2)) @ rng.uniform(0.5, 1.5, (2, 3))
    error = rng.standard_normal((2, *exact.shape)) * NOISE / np.sqrt(2)
    receptance = exact * (1 + error[0] + 1j * error[1])
    weight = 1 / (NOISE * np.abs(exact)) ** 2
    stretch = Stretch(FREQ, receptance, weight, known=True)
    return Refined(fit_modes(FREQ, receptance, weight, EIGENVALUE), weight, ()), stretch


def vaguer(fit: ModalFit, by: float) -> ModalFit:
    """Return the same modes with larger errors."""
    return replace(
        fit,
        eigenvalue_covariance=by**2 * fit.eigenvalue_covariance,
        modal_constant_error=by * fit.modal_constant_error,
    )


def test_modes_take_over_errors_and_bias_of_those_that_cleaned_their_lines() -> None:
    refined, stretch = fitted()
    known, bias = vaguer(refined.fit, 3.0), np.array([[0.2, 0.01], [0.1, 0.02]])
    leaked = Leaked(Leakage.of(HANN, "h1"), known, bias, drive=0)
    out = allowing_for_leakage(refined, stretch, leaked, Damping.STRUCTURAL)
    np.testing.assert_allclose(out.fit.frequency_error, 3 * refined.fit.frequency_error)
    np.testing.assert_allclose(out.fit.loss_factor_error, 3 * refined.fit.loss_factor_error)
    np.testing.assert_allclose(out.fit.modal_constant_error, 3 * refined.fit.modal_constant_error)
    assert out.leakage_bias is not None
    np.testing.assert_allclose(out.leakage_bias, bias)
    surer = replace(leaked, modes=vaguer(refined.fit, 0.1))
    kept = allowing_for_leakage(refined, stretch, surer, Damping.STRUCTURAL)
    np.testing.assert_allclose(kept.fit.eigenvalue_covariance, refined.fit.eigenvalue_covariance)


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
    leaked = Leaked(Leakage.of(HANN, "h1"), None if none else first, np.zeros((1 - none, 2)), drive=0)
    bias = allowing_for_leakage(refined, stretch, leaked, Damping.STRUCTURAL).leakage_bias
    assert bias is not None
    # half a line in frequency; a line's width of damping is more than the second mode has
    np.testing.assert_allclose(bias[1], [0.25, fit.loss_factor[1]])
    if none:
        np.testing.assert_allclose(bias[0], [0.25, 0.5 / fit.frequency[0]])
    else:
        assert (bias[0] < 0.05 * np.array([0.25, fit.loss_factor[0]])).all()
