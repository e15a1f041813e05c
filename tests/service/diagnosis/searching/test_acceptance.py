"""When an effect is told from nothing by the size that it was given."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.trial.rigs import bench
from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.fitting.covariance import ParameterErrors
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.frf_selection import FrfSelection
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.residuals.residual import Residual
from modallab.diagnosis.result import Verdict
from modallab.diagnosis.searching.acceptance import (
    is_nonzero,
    is_significant,
    model_probabilities,
    ranked_by_bic,
)
from modallab.diagnosis.searching.gap_tests import is_noise_only
from modallab.effects.accelerometer_mass import AccelerometerMass
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.gain_error import GainError
from modallab.effects.ground_spring import GroundSpring
from modallab.effects.mains_hum import MainsHum
from modallab.effects.quantisation import Quantisation
from modallab.effects.stinger_axial import StingerAxial
from modallab.effects.suspension import SuspensionStiffness
from modallab.effects.transverse_sensitivity import TransverseSensitivity
from modallab.rig.measure import Route, measure
from tests.diagnosing import draw_measurement, model, predicting, rig

HERE = Channels((Dof(5, "Y"),))


def test_an_amount_within_two_standard_errors_of_none_is_no_effect() -> None:
    assert is_nonzero(GainError(HERE, 1.05), {"factor": 0.02})
    assert not is_nonzero(GainError(HERE, 1.05), {"factor": 0.03})
    assert not is_nonzero(MainsHum(HERE, 0.01, 50.0), {"ratio": 0.006, "frequency": 0.02})


def test_random_errors_that_are_estimated_leave_as_much_of_a_gap() -> None:
    # Variances 15 % too small, 4.5 times the scatter of the gap of 966 lines, and 1.5 times their own error.
    test = draw_measurement(rig(averages=100, roving=False), seed=1)
    gaps = []
    for error in (None, 10.0):
        predictor, observed = predicting(replace(test, averages_error=error))
        assert observed.scale_error == pytest.approx(0.0 if error is None else 10 / 98)
        found = fit(predictor, ())
        frf = found.residual.frf
        frf = frf * np.sqrt(1.15 / (np.abs(frf[observed.fitted]) ** 2).mean())
        frfs_alone = Residual(frf, None, None, averages=100.0)
        gaps.append(is_noise_only(predictor, replace(found, residual=frfs_alone)))
    assert gaps == [False, True]


def test_an_amount_whose_direction_nothing_tells_is_left_to_the_likelihood() -> None:
    # Of a plane frame only sensitivity x cos(angle) counts: near 0 the angle may be anything, and with it
    # the sensitivity has any error, however well their product is known.
    tilted = TransverseSensitivity(HERE, -0.104, 0.009)
    assert is_nonzero(tilted, {"sensitivity": 0.47, "angle": np.pi})
    assert not is_nonzero(tilted, {"sensitivity": 0.47, "angle": 0.01})


def test_what_the_held_out_frfs_could_not_tell_is_borne_out_by_lines_that_were_held_out() -> None:
    # All accelerometers of the frame hear sideways motion, but only 8:+Y, at the corner, has much of it.
    where = bench(("transverse_sensitivity",), np.random.default_rng(1), noise=1e-3, leaking=False)
    everywhere = TransverseSensitivity(None, 0.0033, 0.0)
    held_out = (Dof(2, "X"), Dof(5, "X"), Dof(12, "Y"))

    def convinced(*acting: TransverseSensitivity) -> bool:
        rng = np.random.default_rng(3)
        test = measure(where.structure, where.setup, acting, route=Route.DRAWN, rng=rng)
        observed = observe(test, [FrfSelection(dof) for dof in held_out], fraction=0.0)
        predictor = SingleTestPredictor.of(where.structure, where.setup, observed)
        return is_significant(predictor, fit(predictor, ()), fit(predictor, (everywhere,)))

    assert convinced(everywhere)
    assert not convinced()


def test_hum_in_one_line_of_one_channel_needs_no_witness() -> None:
    # On a line of 2.5 Hz spacing, and not one that is held out: no other line and no other channel has it.
    hum = MainsHum(HERE, 0.01, 62.5)

    def convinced(*acting: MainsHum) -> bool:
        test = draw_measurement(rig(), acting, seed=4)
        observed = observe(test, [FrfSelection(Dof(2, "Y"))], fraction=0.0)
        predictor = SingleTestPredictor.of(model(), test.setup, observed)
        return is_significant(predictor, fit(predictor, ()), fit(predictor, (hum,)))

    assert convinced(hum)
    assert not convinced()


@pytest.mark.parametrize(("step", "missing"), [(0.0, False), (0.0039, False), (0.016, True)])
def test_noise_of_a_channel_is_unexplained_only_beyond_the_error_of_its_level(
    step: float, *, missing: bool
) -> None:
    # Steps of 0.0039 and 0.016 of the signal add 0.1 and 1.7 of the declared noise to that of one channel.
    test = draw_measurement(rig(noise=1e-5), [Quantisation(HERE, step)] if step else [], seed=4)
    observed = observe(test, [FrfSelection(Dof(2, "Y"))], fraction=0.0)
    predictor = SingleTestPredictor.of(model(), test.setup, observed)
    plain, rounded = fit(predictor, ()), fit(predictor, (Quantisation(HERE, 0.004),))
    assert (plain.bic - rounded.bic > 50.0) == (step > 0), "by random error alone it is sure"
    assert is_noise_only(predictor, plain) != missing
    assert is_significant(predictor, plain, rounded) == missing


def test_what_is_missing_smoothly_is_not_taken_for_leakage() -> None:
    # The force of a stinger gives way over the whole range: its residuals go together as leaked ones may.
    leaky = rig(kind="random", window="hann", roving=False)
    kinds = ["stinger_axial", "response_noise", "extra_mass"]
    gives_way = draw_measurement(leaky, [StingerAxial(None, 5e5)], seed=3)
    (step,) = diagnose(model(), gives_way, suspects=kinds).steps
    assert step.effect.kind == "stinger_axial"
    # fits of eight draws scatter by 1.3 %: four times that
    assert step.effect.parameters["stiffness"].value == pytest.approx(5e5, rel=0.053)
    assert (
        diagnose(model(), draw_measurement(leaky, seed=3), suspects=kinds).verdict is Verdict.NOTHING_MISSING
    )


@pytest.mark.parametrize(("deviations", "missing"), [(1.5, False), (3.5, True)])
def test_an_effect_is_significant_beyond_the_limit_of_its_tolerance(
    deviations: float, *, missing: bool
) -> None:
    # Three standard deviations of the mass are tolerated, so that the effect is half of one or so, with an
    # error of one: the fit without it is far off all the same.
    test = draw_measurement(rig(noise=1e-6), [AccelerometerMass(mass=0.002 * deviations)], seed=3)
    found = diagnose(
        model(),
        test,
        suspects=["accelerometer_mass", "extra_mass"],
        tolerances=Tolerances(accelerometer_mass=0.1),
    )
    assert [step.effect.kind for step in found.steps] == ["accelerometer_mass"] * missing
    assert found.verdict is (Verdict.EXPLAINED if missing else Verdict.NOTHING_MISSING)


@pytest.fixture(scope="module")
def springs() -> tuple[Fit, Fit]:
    """A spring to the ground, and a band at the same place whose loss leaves far less than it."""
    test = draw_measurement(rig(), [GroundSpring(Dof(4, "Y"), 2e4)], seed=3)
    predictor = SingleTestPredictor.of(model(), test.setup, observe(test, (), fraction=0.25))
    plain, lossy = (fit(predictor, (cls(Dof(4, "Y"), 2e4),)) for cls in (GroundSpring, SuspensionStiffness))
    return plain, replace(lossy, chi_square=plain.chi_square - 50.0)


def with_error_of_loss(band: Fit, errors_away: float) -> Fit:
    error = band.effects[-1].parameters["loss_factor"] / errors_away
    found = ParameterErrors(({"stiffness": 10.0, "loss_factor": error},), np.zeros(0))
    return replace(band, compute_errors=lambda: found)


def test_a_number_more_has_to_be_told_from_nothing_by_its_own_standard_error(
    springs: tuple[Fit, Fit],
) -> None:
    plain, band = springs
    unsure, sure = (with_error_of_loss(band, away) for away in (1.8, 6.0))
    assert ranked_by_bic([unsure, plain])[0] is plain, "chi-square alone counts lines that leakage ties"
    assert ranked_by_bic([sure, plain])[0] is sure
    assert ranked_by_bic([unsure])[0] is unsure


def test_what_an_incomplete_model_leaves_needs_a_gain_over_its_own_size(springs: tuple[Fit, Fit]) -> None:
    plain, band = springs
    sure = with_error_of_loss(band, 6.0)
    missing = 1e3 * plain.n_data
    far_plain, far_sure = (replace(f, chi_square=f.chi_square + missing) for f in (plain, sure))
    assert ranked_by_bic([far_sure, far_plain])[0] is far_plain, "50 of a thousand times the noise is chance"
    nearer = replace(far_sure, chi_square=far_plain.chi_square - 50.0 * 1e3)
    assert ranked_by_bic([nearer, far_plain])[0] is nearer


def test_shares_of_belief_follow_the_order(springs: tuple[Fit, Fit]) -> None:
    plain, band = springs
    test = draw_measurement(rig(), seed=3)
    predictor = SingleTestPredictor.of(model(), test.setup, observe(test, (), fraction=0.25))
    first, second = model_probabilities(predictor, [plain, with_error_of_loss(band, 1.8)])
    assert first > 0.8 > 0.2 > second > 0.01, "three units of BIC or so: a loss is not ruled out either"


def test_what_is_surely_more_is_as_good_as_it_fits_however_bad_the_plainer_one_is(
    springs: tuple[Fit, Fit],
) -> None:
    plain, band = springs
    sure = with_error_of_loss(band, 6.0)
    other = replace(plain, effects=(ExtraMass(Dof(4, "Y"), 0.01),), chi_square=plain.chi_square + 1e3)
    far = replace(plain, chi_square=plain.chi_square + 1e6)
    assert ranked_by_bic([other, far, sure])[0] is sure


def test_numbers_of_which_only_their_product_is_told_are_judged_by_how_well_they_fit(
    springs: tuple[Fit, Fit],
) -> None:
    # So are mass and drag of a cable whose loss alone shows: each has any error, their product has little
    plain, band = springs
    found = ParameterErrors(
        ({name: 10 * value for name, value in band.effects[-1].parameters.items()},), np.zeros(0)
    )
    together = replace(band, compute_errors=lambda: found)
    assert ranked_by_bic([together, plain])[0] is together
