"""Coarse predictions of additions to some effects."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.gain_error import GainError
from modallab.effects.mains_hum import MainsHum
from modallab.effects.misplaced_accelerometer import MisplacedAccelerometer
from modallab.effects.mounted_resonance import MountedResonance
from modallab.effects.stinger_axial import StingerAxial
from modallab.effects.swapped_channels import SwappedChannels
from modallab.rig.effect import Effect
from tests.diagnosing import draw_measurement, exact, predicting, rig

MASS = ExtraMass(Dof(4, "Y"), 0.05)
HARDENING = CubicStiffness(Dof(5, "Y"), 1e10)
FOURTH, FIFTH = Dof(4, "Y"), Dof(5, "Y")  # nodes of the third and the fourth run


@pytest.fixture(scope="module")
def predictor() -> Predictor:
    return predicting(draw_measurement(rig(), [MASS]))[0]


@pytest.mark.parametrize(
    ("added", "runs"),
    [
        (GainError(Channels((FOURTH,)), 1.1), [2]),
        (MountedResonance(Channels((FIFTH,)), 900.0, 0.05), [3]),
        (MisplacedAccelerometer(Channels((FOURTH,)), 0.05), [2]),
        (SwappedChannels(Channels((FOURTH, FIFTH))), [2, 3]),
        (MainsHum(Channels((FIFTH,)), 0.05), [3]),
        (GainError(Channels((Dof(3, "Y"),)), 1.1), []),
        (GainError(None, 1.1), None),
        (ExtraMass(FOURTH, 0.05), None),
        (CubicStiffness(FOURTH, 1e8), None),
    ],
    ids=lambda value: value.kind if isinstance(value, Effect) else str(value),
)
def test_an_effect_of_one_channel_is_predicted_by_its_own_run(
    added: Effect, runs: list[int] | None, predictor: Predictor
) -> None:
    """As if all runs were predicted, but for the rounding of products of other sizes."""
    (test,) = predictor.tests
    base = test.coarse_spectra.base([MASS])
    assert base.changed_runs([MASS, added], test.setup) == runs
    alone, all_runs = test.coarse_spectra.predict([MASS, added], base), test.coarse([MASS, added])
    np.testing.assert_allclose(alone.h, all_runs.h, rtol=1e-9)
    np.testing.assert_allclose(
        alone.incoherent, all_runs.incoherent, rtol=1e-6, atol=1e-9 * np.max(alone.force)
    )


def test_additions_in_separate_runs_are_predicted_together(predictor: Predictor) -> None:
    """As each of them alone, but for rounding; two in one run, or one on the structure, are kept apart."""
    additions = [
        MountedResonance(Channels((FOURTH,)), 900.0, 0.05),
        MountedResonance(Channels((FIFTH,)), 900.0, 0.05),
        GainError(Channels((FIFTH,)), 1.1),
        ExtraMass(FOURTH, 0.05),
        GainError(Channels((Dof(3, "Y"),)), 1.1),
    ]
    (test,) = predictor.tests
    base = test.coarse_spectra.base([MASS])
    batches = base.batches(additions, test.setup)
    assert batches == [{0: [2], 1: [3], 4: []}, {2: [3]}, {3: None}]
    prediction = predictor.coarse_prediction([MASS])
    for addition, together in zip(additions, prediction.predict_each(additions), strict=True):
        alone = prediction.predict([MASS, addition])
        np.testing.assert_allclose(together.h, alone.h, rtol=1e-9)
        np.testing.assert_allclose(together.force, alone.force, rtol=1e-9)
        np.testing.assert_allclose(
            together.incoherent, alone.incoherent, rtol=1e-6, atol=1e-9 * np.max(alone.force)
        )


def test_only_what_is_added_to_the_base_may_be_left_out(predictor: Predictor) -> None:
    (test,) = predictor.tests
    base = test.coarse_spectra.base([MASS])
    gain = GainError(Channels((FOURTH,)), 1.1)
    assert base.changed_runs([gain], test.setup) is None
    assert base.changed_runs([MASS.with_parameters({"mass": 0.06}), gain], test.setup) is None


def test_linear_additions_keep_the_linearisation_of_a_nonlinear_force() -> None:
    """For the price of a linear prediction, and with nearly the change of the full one."""
    predictor, _ = predicting(draw_measurement(rig(kind="random", window="hann"), [HARDENING]))
    base = predictor.coarse_spectra.base([HARDENING])
    assert base.linearised is not None
    assert base.changed_runs([HARDENING, GainError(Channels((FOURTH,)), 1.1)], predictor.setup) == [2]
    prediction, spent = predictor.coarse_prediction([HARDENING]), predictor.budget.spent
    unmodified, added = prediction.predict([HARDENING]), prediction.predict([HARDENING, MASS])
    assert predictor.budget.spent - spent == pytest.approx(1), (
        "one linear prediction; a nonlinear one counts ten"
    )
    exact = [
        predictor.predict(effects).at(predictor.coarse_places) for effects in ([HARDENING], [HARDENING, MASS])
    ]
    np.testing.assert_allclose(unmodified.h, exact[0].h, rtol=1e-9)
    np.testing.assert_allclose(unmodified.incoherent, exact[0].incoherent, rtol=1e-6)
    coarse_change, change = (np.log(b.h / a.h) for a, b in ((unmodified, added), exact))
    near = np.abs(coarse_change - change).mean() / np.abs(change).mean()
    # A mass changes the motion at the force too, and so its equivalent stiffness: 7 to 15 % of the change.
    assert near < 0.1


def test_beside_a_nonlinear_force_another_one_is_predicted_with_its_distortion() -> None:
    predictor, _ = predicting(draw_measurement(rig(kind="random", window="hann"), [HARDENING]))
    softer = HARDENING.with_parameters({"stiffness": 0.99 * HARDENING.stiffness})
    prediction = predictor.coarse_prediction([HARDENING])
    for effects in ([HARDENING, CubicStiffness(FIFTH, 1e5)], [softer]):
        coarse, exact = prediction.predict(effects), predictor.predict(effects).at(predictor.coarse_places)
        # 0.2 % is what the coarse grid of distortion leaves; without distortion it would be a factor.
        np.testing.assert_allclose(coarse.incoherent, exact.incoherent, rtol=0.01)


# With a nonlinear force the stinger changes the motion too, and the distortion is that of the other motion.
@pytest.mark.parametrize(
    ("base", "largest"), [((), 0.01), ((HARDENING,), 0.1)], ids=["linear", "with distortion"]
)
def test_noise_beside_a_resonance_of_the_stinger_is_that_of_all_lines_with_and_without_it(
    base: tuple[Effect, ...], largest: float
) -> None:
    """Means of channels over few lines differ from those over all by up to 40 %."""
    setup = rig(noise=1e-5)
    setup = replace(setup, analyser=replace(setup.analyser, n_lines=641))
    test, _ = predicting(exact(setup, base))
    assert test.step > 1
    stinger = StingerAxial(None, stiffness=2e6, loss_factor=0.01)
    coarse = test.coarse_prediction(base).predict([*base, stinger])
    near = test.predict([*base, stinger]).at(test.coarse_places)
    # The resonance lies above the band, no power leaks: what few lines leave out has no part in it.
    np.testing.assert_allclose(coarse.force, near.force, rtol=0.01)
    np.testing.assert_allclose(coarse.incoherent, near.incoherent, rtol=largest)
