import numpy as np

from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.fitting.visible_nuisances import with_visible_nuisances
from modallab.diagnosis.optimisation.nuisance_parameters import nuisance_parameters
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.searching.gap_tests import is_noise_only
from tests.diagnosing import draw_measurement, predicting, rig

TOLERANCES = Tolerances(modal_loss_factor=0.3)


def with_loss_above_band(noise: float, deviation: float) -> SingleTestPredictor:
    """Return the predictor of a test where the lowest mode above the band deviates, all parameters free."""
    setup = rig(noise=noise)
    predictor, _ = predicting(draw_measurement(setup))
    numbers = nuisance_parameters(TOLERANCES, predictor.system, setup)
    position = np.zeros(len(numbers))
    position[numbers.optional[0]] = deviation
    predictor, _ = predicting(draw_measurement(setup, numbers.effects(position)))
    return predictor.with_nuisances(numbers)


def test_a_loss_factor_above_the_band_is_free_where_the_test_shows_it() -> None:
    all_free = with_loss_above_band(1e-5, 2.5)
    predictor = with_visible_nuisances(all_free)
    visible = predictor.nuisances.optional
    assert 0 < len(visible) < len(all_free.nuisances.optional)
    found = fit(predictor, ())
    assert is_noise_only(predictor, found)
    error = found.nuisance_errors[visible[0]]
    assert abs(found.nuisance_position[visible[0]] - 2.5) < 4 * error  # four standard errors
    declared = predictor.with_nuisances(predictor.nuisances.without(visible))
    assert not is_noise_only(declared, fit(declared, ()))


def test_a_loss_factor_that_noise_hides_keeps_its_declared_value() -> None:
    predictor = with_visible_nuisances(with_loss_above_band(0.3, 2.5))
    assert not len(predictor.nuisances.optional)
    assert len(predictor.nuisances)  # those of the band are free whatever the noise
    assert is_noise_only(predictor, fit(predictor, ()))


def with_uneven_members(noise: float) -> SingleTestPredictor:
    """Return the predictor of a test where a small shape of the modulus deviates, all parameters free."""
    setup = rig(noise=noise)
    predictor, _ = predicting(draw_measurement(setup))
    numbers = nuisance_parameters(Tolerances(modulus_variation=1e-3), predictor.system, setup)
    position = np.zeros(len(numbers))
    position[numbers.optional[0]] = 2.5
    predictor, _ = predicting(draw_measurement(setup, numbers.effects(position)))
    return predictor.with_nuisances(numbers)


def test_a_small_shape_of_the_members_is_free_where_the_test_shows_it() -> None:
    all_free = with_uneven_members(1e-5)
    first = int(all_free.nuisances.optional[0])
    predictor = with_visible_nuisances(all_free)
    found = fit(predictor, ())
    assert is_noise_only(predictor, found)
    error = found.nuisance_errors[first]
    assert abs(found.nuisance_position[first] - 2.5) < 4 * error  # four standard errors
    large_alone = predictor.with_nuisances(all_free.nuisances.without(all_free.nuisances.optional))
    assert not is_noise_only(large_alone, fit(large_alone, ()))


def test_small_shapes_that_noise_hides_are_not_fitted() -> None:
    quiet, noisy = (with_visible_nuisances(with_uneven_members(noise)).nuisances for noise in (1e-5, 0.3))
    assert len(noisy.optional) < len(quiet.optional)
    assert set(noisy.shapes_of("modulus_variation")) >= set(range(noisy.field.n_large))
