"""What may differ a little is fitted with every effect, within its limits, and is no missing effect."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.diagnosis.fitting.coarse_fit import coarse_fit
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.optimisation.nuisance_parameters import nuisance_parameters
from modallab.diagnosis.optimisation.nuisances import Nuisances, draw_positions
from modallab.diagnosis.optimisation.settings import NUISANCE
from modallab.diagnosis.optimisation.tolerance_effects import LossTolerance
from modallab.diagnosis.optimisation.tolerances import TolerancePreset, Tolerances
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.residual import residual
from modallab.diagnosis.searching.gap_tests import is_noise_only
from modallab.effects.damping_law import DampingLaw
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.loss_factor_error import LossFactorError
from modallab.effects.stiffness_error import StiffnessError
from modallab.fe.assembly import assemble
from modallab.rig.effect import Effect
from modallab.rig.measure import Route, measure
from modallab.rig.setup import RigSetup
from tests.diagnosing import draw_measurement as measured
from tests.diagnosing import model, predicting, rig

ALL = Tolerances(
    modulus=0.003,
    density=0.002,
    sensitivity=0.005,
    accelerometer_mass=0.03,
    delay=1e-6,
    modal_loss_factor=0.2,
)
MASS = ExtraMass(at=Dof(5, "Y"), mass=0.1)


def allowing(
    setup: RigSetup, true: FloatArray, hidden: tuple[Effect, ...] = (), *, seed: int = 0
) -> tuple[SingleTestPredictor, Nuisances]:
    """Return the predictor of a measurement of a test so far off what is declared, tolerating it."""
    numbers = nuisance_parameters(ALL, assemble(model()), setup)
    predictor, _ = predicting(measured(setup, [*numbers.effects(true[: len(numbers)]), *hidden], seed=seed))
    return predictor.with_nuisances(numbers), numbers


def varied(tolerances: Tolerances, setup: RigSetup, seed: int) -> tuple[Effect, ...]:
    """Return what a true test has that is not quite as declared."""
    numbers = nuisance_parameters(tolerances, assemble(model()), setup)
    return numbers.effects(draw_positions(len(numbers), np.random.default_rng(seed)))


def off(seed: int) -> FloatArray:
    return np.random.default_rng(seed).standard_normal(40).clip(-2.5, 2.5)


@pytest.mark.parametrize(("kind", "roving"), [("random", True), ("periodic_random", False)])
def test_a_mass_is_found_beside_all_that_is_a_little_off(kind: str, roving: bool) -> None:
    setup = rig(kind=kind, window="hann" if kind == "random" else "rectangular", roving=roving)
    predictor, numbers = allowing(setup, true := off(1), (MASS,))
    alone = fit(predictor, ())
    assert not is_noise_only(predictor, alone)  # no tolerance explains 100 g
    near, _ = coarse_fit(
        predictor.with_nuisances_at(alone.starting_position).coarse_prediction(()),
        (),
        MASS.with_parameters({"mass": 0.03}),
        0.3,
    )
    found = fit(predictor.with_nuisances_at(alone.starting_position), [near])
    assert is_noise_only(predictor, found)
    error = found.errors[0]["mass"]
    assert abs(found.effects[0].parameters["mass"] - 0.1) < 4 * error  # four standard errors
    apart = (found.nuisance_position - true[: len(numbers)]) / found.nuisance_errors
    assert np.abs(apart).max() < 4.5  # the largest of nineteen


def test_stated_errors_of_what_is_tolerated_are_its_scatter() -> None:
    setup = rig(noise=1e-3)
    numbers = nuisance_parameters(ALL, assemble(model()), setup)
    rng = np.random.default_rng(0)
    scores = []
    for seed in range(14):
        true = rng.standard_normal(len(numbers)).clip(-2, 2)
        predictor, _ = allowing(setup, true, seed=seed)
        found = fit(predictor, ())
        scores.append((found.nuisance_position - true) / found.nuisance_errors)
    squares = np.mean(np.square(scores))
    # 126 squares, of a few correlated numbers: known to 15 %, three of them. Truth is drawn from the prior.
    assert 0.55 < squares < 1.45


def test_a_fit_near_another_one_ends_at_the_same_place() -> None:
    predictor, _ = allowing(rig(kind="random", window="hann"), off(3), (MASS,))
    alone = fit(predictor, ())
    from_start, near = fit(predictor, (MASS,)), fit(predictor, (MASS,), near=alone)
    assert near.nuisance_derivatives is alone.nuisance_derivatives
    # A fit ends where its steps gain less than a thirtieth of a standard deviation of each parameter.
    assert abs(near.chi_square - from_start.chi_square) < 0.1
    amounts = [each.effects[0].parameters["mass"] for each in (near, from_start)]
    assert abs(amounts[0] - amounts[1]) < 0.1 * near.errors[0]["mass"]


def test_an_effect_that_changes_what_a_tolerance_does_is_fitted_with_it_from_anywhere() -> None:
    # Four times the loss of the model is four times what its modes lose more than modelled; of what follows
    # the other law the same share.
    hidden = (DampingLaw(share=0.7, frequency=200.0), LossFactorError(factor=4.0))
    predictor, _ = allowing(rig(), off(2), hidden)
    law, loss = hidden
    starts = [(0.7, 4.0), (0.4, 2.5), (0.9, 6.0)]
    found = [
        fit(predictor, [law.with_parameters({"share": share}), loss.with_parameters({"factor": factor})])
        for share, factor in starts
    ]
    least = min(one.chi_square for one in found)
    # A fit ends within a hundredth of a standard error, 1e-4 of a square; wrong slopes end it early.
    assert max(one.chi_square for one in found) < least + 0.1
    assert all(is_noise_only(predictor, one) for one in found)


def test_limits_hold_against_any_amount_of_data() -> None:
    predictor, numbers = allowing(rig(), np.zeros(40), (StiffnessError(factor=1.05),))
    found = fit(predictor, ())
    limits = predictor.nuisances.limits
    assert (np.abs(found.nuisance_position) <= limits).all()
    assert not is_noise_only(predictor, found)
    assert numbers.parameters[0].name == "modulus"
    assert limits[0] == NUISANCE.max_deviation
    assert found.nuisance_position[0] == pytest.approx(limits[0], rel=1e-12)  # rounding of the last step


def test_of_many_parameters_alike_the_largest_passes_its_limit_as_rarely_as_a_single_one() -> None:
    _, numbers = allowing(rig(), np.zeros(40), ())
    number = sum(each.mode is not None for each in numbers.parameters)
    assert number > 3
    draws = np.abs(np.random.default_rng(3).standard_normal((200_000, number)))
    passes = (draws.max(axis=1) > numbers.limits[-1]).mean()
    wanted = 2 * norm.sf(NUISANCE.max_deviation)
    assert abs(passes - wanted) < 4 * np.sqrt(wanted / 200_000)  # four standard errors of a count


def test_an_effect_like_what_is_tolerated_is_the_whole_departure_and_carries_the_tolerance() -> None:
    predictor, _ = allowing(rig(), np.zeros(40), (StiffnessError(factor=1.05),))
    found = fit(predictor, [StiffnessError(factor=1.04)])
    assert is_noise_only(predictor, found)
    error = found.errors[0]["factor"]
    # What the log book leaves open: the modulus, and some of the density that looks like it; noise is 1e-5.
    assert 0.003 * 1.05 < error < np.hypot(0.003, 0.002) * 1.05
    assert abs(found.effects[0].parameters["factor"] - 1.05) < 0.5 * error  # drawn back to what is declared
    assert abs(found.nuisance_position[0]) < 0.5


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("roving", [True, False])
def test_a_test_within_tolerances_misses_nothing(roving: bool, seed: int) -> None:
    setup = rig(roving=roving)
    true = varied(ALL, setup, seed)
    rng = np.random.default_rng(seed)
    measurement = measure(model(), setup, true, route=Route.SAMPLED, rng=rng)
    predictor, _ = predicting(measurement)
    assert not is_noise_only(predictor, fit(predictor, ()))  # without tolerances much is
    predictor = predictor.with_nuisances(nuisance_parameters(ALL, assemble(model()), setup))
    assert is_noise_only(predictor, fit(predictor, ()))


def test_loss_factors_are_tolerated_on_a_logarithmic_scale() -> None:
    """2.6 standard deviations of 30 % are a factor of 2.2, which on a linear scale would be 3.9 of them."""
    tolerances = Tolerances(modal_loss_factor=0.3)
    numbers = nuisance_parameters(tolerances, assemble(model()), rig())
    declared = numbers.loss_factors
    true = LossTolerance(more=tuple(1.2 * eta if i == 2 else 0.0 for i, eta in enumerate(declared)))
    predictor, _ = predicting(measured(rig(), [true]))
    found = fit(predictor.with_nuisances(numbers), ())
    assert is_noise_only(predictor.with_nuisances(numbers), found)
    third = numbers.parameters[2].value(found.nuisance_position[2])
    assert third == pytest.approx(2.2, rel=0.05)  # the prior draws it back a little
    for loss, limit in zip(numbers.parameters, numbers.limits, strict=True):
        assert loss.value(-limit) > 0  # a mode without damping, or with less, is none


def test_a_model_far_off_within_its_tolerances_is_found_from_the_declared_one() -> None:
    """Resonances shift by bandwidths: without inflated errors the fit ended in a local minimum."""
    tolerances = Tolerances.preset(TolerancePreset.STUDENT)
    numbers = nuisance_parameters(tolerances, assemble(model()), rig())
    true = np.random.default_rng(3).standard_normal(len(numbers)).clip(-2.5, 2.5)
    predictor, _ = predicting(measured(rig(), numbers.effects(true), seed=3))
    declared = predictor.with_nuisances(numbers)
    assert is_noise_only(declared, fit(declared, ()))


def test_derivatives_by_nuisance_parameters_are_those_of_moved_positions() -> None:
    """Also by loss factors on a logarithmic scale, and by factors that are far from 1."""
    wide = replace(ALL, modulus=0.03, density=0.03, sensitivity=0.05)
    predictor, _ = allowing(rig(), off(0))
    numbers = nuisance_parameters(wide, assemble(model()), rig())
    predictor = predictor.with_nuisances(numbers)
    position = 2.0 * off(1)[: len(numbers)]
    near = predictor.with_nuisances_at(position)
    observed, step = predictor.observed, 1e-4

    def vector(at: FloatArray) -> FloatArray:
        return residual(observed, predictor.with_nuisances_at(at).predict(())).vector(observed.fitted)

    derivatives = numbers.derivatives(
        near.linearisation_at(()),
        lambda predicted: residual(observed, predicted).vector(observed.fitted),
        near.linearisation_at(())(()),
        observed,
        position,
        np.arange(len(numbers)),
    )
    for i, derivative in enumerate(derivatives.T):
        shift = step * (np.arange(len(numbers)) == i)
        central = (vector(position + shift) - vector(position - shift)) / (2 * step)
        # Rounding of parameters that hardly act: 4e-4 of the loss factor of a mode far above the band.
        assert np.linalg.norm(derivative - central) < 2e-3 * np.linalg.norm(central)


def test_what_belongs_to_a_held_out_channel_is_read_off_that_channel() -> None:
    predictor, numbers = allowing(rig(roving=False), true := off(2))
    held = np.array([False, False, True, False, False, True])
    predictor = replace(predictor, observed=replace(predictor.observed, held_out=held))
    found = fit(predictor, ())
    assert is_noise_only(predictor, found)  # held out ones included
    own = [i for i, one in enumerate(numbers.parameters) if str(one.at) == "channels 4:+Y"]
    assert [numbers.parameters[i].name for i in own] == ["sensitivity", "delay"]
    apart = (found.nuisance_position - true[: len(numbers)])[own] / found.nuisance_errors[own]
    assert np.abs(apart).max() < 4  # in standard errors


def test_residuals_are_cleared_of_what_is_tolerated_and_of_nothing_else() -> None:
    predictor, numbers = allowing(rig(), true := 0.3 * off(3))
    coarse = predictor.coarse_prediction(())

    def left(*effects: Effect) -> FloatArray:
        observed = coarse.observed
        return residual(observed, coarse.predict(effects)).vector(observed.fitted)

    nothing, right, wrong = left(), left(*numbers.effects(true[: len(numbers)])), left(MASS)
    projected = coarse.project_out(np.array([nothing, wrong]), 0.0)
    # To the second order of a third of a standard deviation: 0.06^2 of a loss factor is many random errors.
    assert projected[0] @ projected[0] - right @ right < 0.01 * (nothing @ nothing - right @ right)
    assert projected[1] @ projected[1] > 0.3 * wrong @ wrong  # 100 g are beyond all limits
    assert predictor.coarse_prediction(()).project_out(nothing, 0.3).shape == (len(nothing) + len(numbers),)


def test_without_tolerances_fits_and_looks_are_as_they_were() -> None:
    predictor, _ = predicting(measured(rig(), [MASS]))
    found: Fit = fit(predictor, [MASS])
    assert found.nuisance_position.shape == found.nuisance_errors.shape == (0,)
    vector = predictor.coarse_prediction(()).observed.freq
    assert predictor.coarse_prediction(()).project_out(vector, 0.0) is vector


def test_truths_lie_within_limits_and_follow_from_the_seed() -> None:
    setup = rig(roving=False)
    first, again = (varied(ALL, setup, 4) for _ in range(2))
    assert first == again
    gains = [e.factor for e in first if e.kind == "gain_error"]  # type: ignore[attr-defined]
    assert len(gains) == len(setup.responses)
    assert np.abs(np.array(gains) - 1).max() <= NUISANCE.max_deviation * 0.005
    assert varied(Tolerances(), setup, 4) == ()


def test_one_accelerometer_that_roves_has_one_sensitivity_and_one_delay() -> None:
    numbers = nuisance_parameters(ALL, assemble(model()), rig(roving=True))
    names = [n.name for n in numbers.parameters]
    assert names.count("sensitivity") == names.count("delay") == 1
    # Elastic modes below 500 Hz: 37, 102, 200, 332, 498 Hz.
    assert names.count("modal_loss_factor") - len(numbers.optional) == 5
    apart = [n.name for n in nuisance_parameters(ALL, assemble(model()), rig(roving=False)).parameters]
    assert apart.count("sensitivity") == apart.count("delay") == 6


@pytest.mark.parametrize(
    ("values", "field"), [({"modulus": -0.1}, "tolerances.modulus"), ({"size": 0.1}, "tolerances")]
)
def test_a_tolerance_that_makes_no_sense_is_refused(values: dict[str, float], field: str) -> None:
    with pytest.raises(InvalidInputError) as refused:
        Tolerances.of(values)
    assert refused.value.context["field"] == field


def test_presets_grow_from_careful_to_student() -> None:
    careful, ordinary, student = (
        Tolerances.preset(preset).stated
        for preset in (TolerancePreset.CAREFUL, TolerancePreset.ORDINARY, TolerancePreset.STUDENT)
    )
    assert set(careful) == set(Tolerances.specs())
    assert all(0 < careful[name] < ordinary[name] < student[name] for name in careful)
    assert not any(Tolerances.preset(TolerancePreset.NONE).stated.values())


def test_what_is_stated_is_kept_and_what_is_left_out_is_completed() -> None:
    stated = Tolerances(modulus=0.0, delay=1e-5)
    completed = stated.completed(Tolerances.preset(TolerancePreset.ORDINARY))
    assert (completed.modulus, completed.delay) == (0.0, 1e-5)
    assert completed.density == Tolerances.preset(TolerancePreset.ORDINARY).density
