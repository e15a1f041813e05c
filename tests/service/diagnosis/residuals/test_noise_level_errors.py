"""Errors of noise levels, taken out of the residuals of incoherent spectra."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.residuals.noise_level_errors import without_noise_level_errors
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import Residual
from tests.diagnosing import exact, predicting, rig


@pytest.fixture(scope="module")
def plain() -> tuple[Observed, Residual]:
    predictor, observed = predicting(exact(rig()))
    return observed, fit(predictor, ()).residual


@pytest.mark.parametrize(("error", "left"), [(0.1, 0.0), (-0.25, 0.0), (0.8, 0.5), (-0.8, -0.5)])
def test_an_error_of_a_level_is_taken_out_as_far_as_it_is_allowed(
    plain: tuple[Observed, Residual], error: float, left: float
) -> None:
    observed, found = plain
    assert found.response is not None
    assert observed.incoherent_variance is not None
    deviation = np.sqrt(observed.incoherent_variance)
    levels = error * np.array([1, 0, 0, 1, 0, 0])
    wrong = replace(found, response=levels / deviation)
    corrected = without_noise_level_errors(observed, wrong, 0.3)
    assert corrected.response is not None
    rest = (corrected.response * deviation)[observed.usable.all(axis=1)]
    assert np.abs(rest - left * np.array([1, 0, 0, 1, 0, 0])).max() < 1e-12  # rounding
    assert corrected.frf is wrong.frf


def test_a_line_alone_is_no_error_of_a_level(plain: tuple[Observed, Residual]) -> None:
    observed, found = plain
    assert found.response is not None
    response = found.response.copy()
    response[40, 2] += 30.0
    corrected = without_noise_level_errors(observed, replace(found, response=response), 0.3)
    assert corrected.response is not None
    # a share of one of 160 lines
    assert corrected.response[40, 2] == pytest.approx(30.0, rel=0.01)


def test_without_incoherent_spectra_nothing_is_taken_out(plain: tuple[Observed, Residual]) -> None:
    observed, found = plain
    alone = replace(found, response=None)
    assert without_noise_level_errors(observed, alone, 0.3) is alone
