"""Which rivals are left, and the test that is proposed beside other effects."""

from collections.abc import Callable

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import Members
from modallab.core.progress import silent
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.equivalent_fits import equivalent_fits
from modallab.diagnosis.searching.search_path import AcceptedEffect, SearchPath
from modallab.diagnosis.test_design.proposal import next_test, possible_rivals
from modallab.effects.attached_oscillator import AttachedOscillator
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.force_transducer_mass import ForceTransducerMass
from modallab.effects.ground_spring import GroundSpring
from modallab.effects.rotational_ground_spring import RotationalGroundSpring
from modallab.effects.stiffness_error import StiffnessError
from modallab.effects.stinger_bending import StingerBending
from modallab.rig.effect import Effect
from tests.diagnosing import draw_measurement, predicting, rig

DRIVE = Dof(1, "Y")
MASS, GAUGE = ExtraMass(at=DRIVE, mass=0.02), ForceTransducerMass(mass=0.02)


def prepared(*hidden: Effect) -> tuple[Predictor, Callable[..., AcceptedEffect]]:
    """Return a predictor of a test, and what makes a step of explanations, the first one accepted."""
    predictor, _ = predicting(draw_measurement(rig(roving=False), hidden))

    def accepted(*last: Effect, beside: tuple[Effect, ...] = ()) -> AcceptedEffect:
        before = fit(predictor, beside)
        tried = tuple(fit(predictor, (*before.effects, effect)) for effect in last)
        return AcceptedEffect((last[0].kind, str(last[0].at)), before, tried[0], tried)

    return predictor, accepted


def kinds(fits: list[Fit]) -> list[str]:
    return [one.effects[-1].kind for one in fits]


def test_an_oscillator_tuned_far_above_the_band_is_no_rival_of_the_mass_that_it_is() -> None:
    predictor, accepted = prepared(MASS)
    far = AttachedOscillator(at=DRIVE, mass=0.02, frequency=5e4, loss_factor=0.05)
    step = accepted(MASS, far, GAUGE)
    # The oscillator explains as much: it has more numbers than the mass, which is on its side.
    assert step.round_fits[1].chi_square == pytest.approx(step.round_fits[0].chi_square, abs=9.0)
    assert kinds(equivalent_fits(predictor, step, step.round_fits[0])) == ["force_transducer_mass"]


def test_a_simpler_model_does_not_clear_the_rig() -> None:
    stinger = StingerBending(stiffness=20.0, length=0.5)
    predictor, accepted = prepared(stinger)
    step = accepted(RotationalGroundSpring(at=Dof(1, "RZ"), stiffness=20.0), stinger)
    assert kinds(equivalent_fits(predictor, step, step.round_fits[0])) == ["stinger_bending"]


def test_what_explains_far_less_is_not_possible() -> None:
    predictor, accepted = prepared(MASS)
    step = accepted(MASS, GroundSpring(at=DRIVE, stiffness=1e3))
    assert possible_rivals(predictor, step, step.round_fits[0]) == []
    path = SearchPath(step.previous_fit, (step,))
    assert next_test(predictor, path, (), silent) is None


def test_a_rival_is_fitted_anew_beside_the_other_effects() -> None:
    stiff = StiffnessError(at=Members((4,)), factor=1.2)
    predictor, accepted = prepared(MASS, stiff)
    first = accepted(stiff)
    second = accepted(MASS, GAUGE, beside=first.fit.effects)
    test = next_test(predictor, SearchPath(first.previous_fit, (first, second)), (), silent)
    assert test is not None
    assert test.separates == ("extra_mass", "force_transducer_mass")
    assert "drive" in test.change
    assert np.isfinite(test.expected_separation)


def test_progress_is_told_while_tests_are_looked_for() -> None:
    predictor, accepted = prepared(MASS)
    step = accepted(MASS, GAUGE)
    told: list[float] = []
    next_test(
        predictor, SearchPath(step.previous_fit, (step,)), (), lambda fraction, _: told.append(fraction)
    )
    assert told == sorted(told)
    assert 0 <= told[0] <= told[-1] <= 1
