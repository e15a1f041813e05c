"""Effects that others equal while more than noise is left."""

from dataclasses import replace

import pytest

from modallab.core.dof import Dof
from modallab.core.place import Members
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import model_probabilities
from modallab.diagnosis.searching.equivalent_fits import equivalent_fits, without_undetermined_effects
from modallab.diagnosis.searching.gap_tests import excess_ratio, unexplained_parts
from modallab.diagnosis.searching.search_path import AcceptedEffect, SearchPath, kind_and_place
from modallab.diagnosis.searching.settings import SEARCH
from modallab.effects.attached_oscillator import AttachedOscillator
from modallab.effects.density_error import DensityError
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.stiffness_error import StiffnessError
from modallab.rig.effect import Effect
from tests.diagnosing import draw_measurement, predicting, rig

JOINT_MASS = ExtraMass(Dof(4, "Y"), 0.05)
UNEVEN = [DensityError(Members((n,)), 1 + 0.01 * (-1) ** n) for n in range(1, 7)]
"""A model that is wrong everywhere by a little."""
MASS, STIFFNESS, DENSITY = (
    ExtraMass(Dof(2, "Y"), 0.001),
    StiffnessError(Members((2,)), 0.99),
    DensityError(Members((2,)), 1.01),
)


@pytest.fixture(scope="module")
def predictor() -> Predictor:
    return predicting(draw_measurement(rig(), [JOINT_MASS, *UNEVEN], seed=3))[0]


def path_of(predictor: Predictor, *second: Effect) -> SearchPath:
    """Return the path of the mass and the best of other effects beside it."""
    start, first = fit(predictor, ()), fit(predictor, (JOINT_MASS,))
    tried = sorted((fit(predictor, (*first.effects, effect)) for effect in second), key=lambda f: f.bic)
    steps = (
        AcceptedEffect(kind_and_place(JOINT_MASS), start, first, (first,)),
        AcceptedEffect(kind_and_place(tried[0].effects[-1]), first, tried[0], tuple(tried)),
    )
    return SearchPath(start, steps)


def with_chi_square(path: SearchPath, values: tuple[float, ...]) -> SearchPath:
    """Return the path with other sums of squares of the fits of its last round."""
    fits = [replace(f, chi_square=value) for f, value in zip(path.steps[-1].round_fits, values, strict=True)]
    last = replace(path.steps[-1], fit=fits[0], round_fits=tuple(fits))
    return replace(path, steps=(*path.steps[:-1], last))


def last(path: SearchPath) -> Fit:
    return path.steps[-1].round_fits[0]


def test_an_effect_that_others_equal_is_not_named_where_more_than_noise_is_left(predictor: Predictor) -> None:
    path = path_of(predictor, MASS, STIFFNESS, DENSITY)
    assert unexplained_parts(predictor, path.fit, max_lag=None), "a model that is wrong everywhere"
    n, excess = last(path).n_data, 20.0 * last(path).n_data
    alike = with_chi_square(path, (n + excess, n + 1.01 * excess, n + 1.02 * excess))
    assert len(equivalent_fits(predictor, alike.steps[-1], last(alike))) == 2
    assert max(model_probabilities(predictor, alike.steps[-1].round_fits)) < 0.6
    assert without_undetermined_effects(predictor, alike).fit.effects == alike.steps[0].fit.effects
    apart = with_chi_square(path, (n + excess, n + 2 * excess, n + 3 * excess))
    assert without_undetermined_effects(predictor, apart) is apart
    assert model_probabilities(predictor, apart.steps[-1].round_fits)[0] > 0.999


def test_an_effect_that_closes_most_of_the_gap_stays_beside_those_that_equal_it() -> None:
    # A large second mass, in a model that is wrong everywhere by a little.
    large = ExtraMass(Dof(2, "Y"), 0.05)
    predictor = predicting(draw_measurement(rig(), [JOINT_MASS, large, *UNEVEN], seed=3))[0]
    path = path_of(predictor, large, STIFFNESS)
    best = last_round(path)[0]
    path = with_chi_square(path, (best.chi_square, 1.01 * best.chi_square))
    assert unexplained_parts(predictor, path.fit, max_lag=None), "a model that is wrong everywhere"
    assert equivalent_fits(predictor, path.steps[-1], last(path))
    ratio = excess_ratio(path.steps[-1].previous_fit, path.fit, predictor.observed.fitted)
    assert ratio < SEARCH.undetermined_ratio
    assert without_undetermined_effects(predictor, path) is path


def test_the_first_effect_stays(predictor: Predictor) -> None:
    path = path_of(predictor, MASS, STIFFNESS)
    first = SearchPath(path.start, path.steps[:1])
    assert without_undetermined_effects(predictor, first) is first


def test_where_only_noise_is_left_effects_stay() -> None:
    predictor = predicting(draw_measurement(rig(), [JOINT_MASS, MASS], seed=3))[0]
    path = path_of(predictor, MASS, STIFFNESS, DENSITY)
    assert not unexplained_parts(predictor, path.fit, max_lag=None)
    assert without_undetermined_effects(predictor, path) is path


def test_an_effect_with_fewer_parameters_takes_the_place_of_one_that_it_equals(predictor: Predictor) -> None:
    far_above_the_band = AttachedOscillator(Dof(2, "Y"), 0.001, 1e5)
    path = path_of(predictor, far_above_the_band, MASS)
    oscillator, mass = sorted(last_round(path), key=lambda f: -f.n_parameters)
    n, excess = mass.n_data, 20.0 * mass.n_data
    fits = replace(oscillator, chi_square=n + excess), replace(mass, chi_square=n + 1.01 * excess)
    step = replace(
        path.steps[-1],
        kind_and_place=kind_and_place(far_above_the_band),
        fit=fits[0],
        round_fits=fits,
    )
    reduced = without_undetermined_effects(predictor, replace(path, steps=(*path.steps[:-1], step)))
    assert [kind_and_place(e) for e in reduced.fit.effects] == [
        kind_and_place(JOINT_MASS),
        kind_and_place(MASS),
    ]
    assert reduced.steps[-1].kind_and_place == kind_and_place(MASS)


def last_round(path: SearchPath) -> tuple[Fit, ...]:
    return path.steps[-1].round_fits
