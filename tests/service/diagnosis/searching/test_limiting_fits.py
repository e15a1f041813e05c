"""Fits of what the best effect tends to at the limits of its parameters."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.trial.rigs import bench
from modallab.core.dof import Dof
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.searching.limiting_fits import with_limiting_effects, with_reduced_model
from modallab.diagnosis.searching.search_path import kind_and_place
from modallab.effects.attached_oscillator import AttachedOscillator
from modallab.effects.extra_mass import ExtraMass
from modallab.rig.measure import Route, measure
from tests.diagnosing import draw_measurement, predicting, rig

PLACE = Dof(4, "Y")


def test_a_mass_whose_fit_ended_elsewhere_is_fitted_from_an_oscillator_far_above_the_band() -> None:
    predictor, _ = predicting(draw_measurement(rig(), [ExtraMass(PLACE, 0.2)]))
    base = fit(predictor, ())
    mass = fit(predictor, [ExtraMass(PLACE, 0.1)])
    elsewhere = replace(mass, chi_square=mass.chi_square + 30)
    oscillator = fit(predictor, [AttachedOscillator(PLACE, mass=0.2, frequency=1e5)])
    fits = with_limiting_effects(predictor, base, [oscillator, elsewhere], {kind_and_place(mass.effects[0])})
    (found,) = [one for one in fits if one.effects[0].kind == "extra_mass"]
    # Two ends of one minimum: far nearer than a unit of chi-square, which is one standard error.
    assert found.chi_square == pytest.approx(mass.chi_square, abs=0.1)


def test_the_mass_at_a_node_of_a_frame_is_the_limit_of_an_oscillator_in_any_direction() -> None:
    """It was looked for in the oscillator's direction, where no mass is suspected, and never fitted."""
    frame = bench(("transverse_sensitivity",), np.random.default_rng(1), noise=1e-5, leaking=False)
    mass = ExtraMass(Dof(5, "X"), 0.2)
    rng = np.random.default_rng(3)
    test = measure(frame.structure, frame.setup, [mass], route=Route.DRAWN, rng=rng)
    predictor = SingleTestPredictor.of(frame.structure, frame.setup, observe(test, (), fraction=0.0))
    oscillator = fit(predictor, [AttachedOscillator(Dof(5, "Y"), mass=0.2, frequency=1e5)])
    fits = with_limiting_effects(predictor, fit(predictor, ()), [oscillator], {kind_and_place(mass)})
    assert kind_and_place(mass) in [kind_and_place(one.effects[0]) for one in fits]


def test_a_limit_that_is_no_suspect_is_not_fitted() -> None:
    predictor, _ = predicting(draw_measurement(rig(), [ExtraMass(PLACE, 0.2)]))
    oscillator = fit(predictor, [AttachedOscillator(PLACE, mass=0.2, frequency=1e5)])
    assert with_limiting_effects(predictor, fit(predictor, ()), [oscillator], set()) == [oscillator]


def test_without_fits_there_is_nothing_to_fit() -> None:
    predictor, _ = predicting(draw_measurement(rig(), []))
    base = fit(predictor, ())
    assert with_limiting_effects(predictor, base, [], set()) == []
    assert with_reduced_model(predictor, base, [], set()) == []
