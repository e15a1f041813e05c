"""Fits of an exciter that resonates between coarse lines: repeated from the best stiffness at all lines."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching import exciter_resonance
from modallab.diagnosis.searching.exciter_resonance import with_resonance_at_lines
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.stinger_axial import StingerAxial
from modallab.rig.effect import Effect
from tests.diagnosing import draw_measurement, predicting, rig

ARMATURE = 0.02  # kg, of the rig
STINGER = StingerAxial(
    stiffness=(2 * np.pi * 38.0) ** 2 * ARMATURE, loss_factor=0.02
)  # lines are 2.5 Hz apart


@pytest.fixture(scope="module")
def predictor() -> Predictor:
    return predicting(draw_measurement(rig(), [STINGER]))[0]


def astray(predictor: Predictor, ratio: float) -> Fit:
    """Return a fit that ended at another stiffness."""
    start = StingerAxial(stiffness=ratio * STINGER.stiffness, loss_factor=0.04)
    return fit(predictor, (start,), max_chi_square=0.0)


@pytest.mark.parametrize("ratio", [0.8, 1.15, 1.3])
def test_a_fit_that_ended_at_another_frequency_finds_the_right_one(
    predictor: Predictor, ratio: float
) -> None:
    candidate, near = astray(predictor, ratio), fit(predictor, ())
    found = with_resonance_at_lines(predictor, candidate, near)
    assert found.chi_square < 0.5 * candidate.chi_square
    stiffness, errors = found.effects[0].parameters["stiffness"], found.errors[0]
    assert abs(stiffness - STINGER.stiffness) < 4 * errors["stiffness"]  # 1 in 16,000 by chance


def no_prediction(*_given: object, **_names: object) -> Fit:
    raise AssertionError("nothing is to be fitted")


@pytest.mark.parametrize("effect", [STINGER, ExtraMass(Dof(4, "Y"), 0.1)])
def test_what_leaves_noise_alone_and_what_is_no_exciter_stays(
    predictor: Predictor, effect: Effect, monkeypatch: pytest.MonkeyPatch
) -> None:
    candidate = fit(predictor, (effect,))
    monkeypatch.setattr(exciter_resonance, "fit", no_prediction)
    assert with_resonance_at_lines(predictor, candidate, fit(predictor, ())) is candidate
