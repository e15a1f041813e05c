from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels, Members, Place
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.residual import residual
from modallab.diagnosis.searching.modification_screen import ModificationScreen
from modallab.effects.accelerometer_mass import AccelerometerMass
from modallab.effects.attached_oscillator import AttachedOscillator
from modallab.effects.cable_mass import CableMass
from modallab.effects.channel_delay import ChannelDelay
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.density_error import DensityError
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.force_noise import ForceNoise
from modallab.effects.gain_error import GainError
from modallab.effects.ground_spring import GroundSpring
from modallab.effects.joint_flexibility import JointFlexibility
from modallab.effects.leakage import Leakage
from modallab.effects.local_damping import LocalDamping
from modallab.effects.loss_factor_error import LossFactorError
from modallab.effects.misplaced_accelerometer import MisplacedAccelerometer
from modallab.effects.mounted_resonance import MountedResonance
from modallab.effects.stiffness_error import StiffnessError
from modallab.effects.stinger_axial import StingerAxial
from modallab.effects.swapped_channels import SwappedChannels
from modallab.rig.effect import Effect
from tests.diagnosing import draw_measurement, predicting, rig

# Noise of 1e-9: with more, a receptance alone does not tell the FRF that H1 shows at an antiresonance.
QUIET = 1e-9


def quiet(*, roving: bool = True) -> Predictor:
    predictor, _ = predicting(draw_measurement(rig(noise=QUIET, roving=roving), []))
    return predictor


@pytest.mark.parametrize(
    ("effect", "larger"),
    [
        (ExtraMass(Dof(4, "Y"), 0.01), {"mass": 0.3}),
        (GroundSpring(Dof(3, "Y"), 1e3), {"stiffness": 1e5}),
        (LocalDamping(Dof(9, "Y"), 0.1), {"damping": 20.0}),
        (AttachedOscillator(Dof(6, "Y"), 0.02, 120.0, 0.05), {"frequency": 200.0}),
        (StiffnessError(Members((3,)), 1.01), {"factor": 2.0}),
        (DensityError(Members((2,)), 0.9), {"factor": 3.0}),
        (LossFactorError(Members((5,)), 3.0), {"factor": 10.0}),
        (JointFlexibility(Dof(5, "RZ"), 1e-5), {"flexibility": 1e-3}),
    ],
    ids=lambda value: value.kind if isinstance(value, Effect) else "",
)
@pytest.mark.parametrize("roving", [True, False])
def test_attachments_to_a_structure_are_predicted_exactly(
    effect: Effect, larger: dict[str, float], roving: bool
) -> None:
    predictor = quiet(roving=roving)
    sizes = [effect, effect.with_parameters(larger)]
    ratios = ModificationScreen(predictor.coarse_prediction([]), []).ratios(sizes)
    assert ratios is not None
    fitted, step = predictor.coarse_prediction([]).observed.fitted, predictor.step
    without = predictor.predict([]).h[::step]
    for size, ratio in zip(sizes, ratios, strict=True):
        predicted = predictor.predict([size]).h[::step] / without
        # H1 is lowered by the force's noise of 1e-9 of its mean, most where an armature lets it drop.
        np.testing.assert_allclose(ratio, predicted[fitted], rtol=1e-4)


def test_sizes_at_one_place_after_the_other_are_those_at_a_place_alone() -> None:
    predictor = quiet()
    one_after_the_other = ModificationScreen(predictor.coarse_prediction([]), [])
    kinds: list[Sequence[Effect]] = [
        [AttachedOscillator(None, mass, 120.0, 0.05) for mass in (0.0, 0.02, 0.3)],
        [ExtraMass(None, mass) for mass in (0.01, 0.1, 1.0)],
        [StiffnessError(None, factor) for factor in (0.3, 0.9, 1.2)],
        [JointFlexibility(None, amount) for amount in (1e-6, 1e-5, 1e-3)],
    ]
    places: list[Sequence[Place]] = [
        [Dof(4, "Y"), Dof(7, "Y")],
        [Dof(4, "Y"), Dof(1, "Y")],
        [Members((2,)), Members((5,)), Members((8,))],
        [Dof(4, "RZ"), Dof(6, "RZ")],
    ]
    for sizes, where in zip(kinds, places, strict=True):
        for at in where:
            here = [replace(size, at=at) for size in sizes]
            alone = ModificationScreen(predictor.coarse_prediction([]), []).ratios(here)
            found = one_after_the_other.ratios(here)
            assert alone is not None
            assert found is not None
            # the same equations, but for a basis of motions that may be another one
            np.testing.assert_allclose(found, alone, rtol=1e-8)


def test_an_effect_beside_an_accepted_one_at_the_same_member_is_predicted_exactly() -> None:
    predictor = quiet()
    accepted, more = StiffnessError(Members((3,)), 0.8), GroundSpring(Dof(3, "Y"), 1e4)
    ratios = ModificationScreen(predictor.coarse_prediction([accepted]), [accepted]).ratios([more])
    assert ratios is not None
    step = predictor.step
    predicted = predictor.predict([accepted, more]).h[::step] / predictor.predict([accepted]).h[::step]
    np.testing.assert_allclose(
        ratios[0], predicted[predictor.coarse_prediction([]).observed.fitted], rtol=1e-4
    )


def test_a_channel_that_measures_two_motions_is_predicted_exactly() -> None:
    predictor = quiet()
    beside, more = MisplacedAccelerometer(Channels((Dof(5, "Y"),)), 0.02), GroundSpring(Dof(3, "Y"), 1e4)
    swapped = SwappedChannels(Channels((Dof(4, "Y"), Dof(5, "Y"))))
    for accepted in (beside, swapped):
        ratios = ModificationScreen(predictor.coarse_prediction([accepted]), [accepted]).ratios([more])
        assert ratios is not None
        both, alone = (predictor.predict(e).h[:: predictor.step] for e in ([accepted, more], [accepted]))
        fitted = predictor.coarse_prediction([]).observed.fitted
        np.testing.assert_allclose(ratios[0], (both / alone)[fitted], rtol=1e-4)


@pytest.mark.parametrize(
    ("effect", "larger"),
    [
        (MountedResonance(None, 900.0, 0.05), {"frequency": 250.0}),
        (MountedResonance(Channels((Dof(5, "Y"),)), 900.0, 0.05), {"frequency": 250.0}),
        (CableMass(None, 0.002, 20.0), {"mass": 0.02}),
        (AccelerometerMass(None, 0.004), {"mass": 0.04}),
        (ChannelDelay(Channels((Dof(5, "Y"),)), 1e-5), {"delay": 1e-3}),
        (ChannelDelay(None, 1e-5), {"delay": 1e-3}),
        (GainError(Channels((Dof(5, "Y"),)), 1.1), {"factor": 3.0}),
        (GainError(Dof(1, "Y"), 1.1), {"factor": 3.0}),
    ],
    ids=lambda value: f"{value.kind} {value.at}" if isinstance(value, Effect) else "",
)
@pytest.mark.parametrize("roving", [True, False])
def test_effects_of_single_runs_and_channels_are_predicted_exactly(
    effect: Effect, larger: dict[str, float], roving: bool
) -> None:
    predictor = quiet(roving=roving)
    sizes = [effect, effect.with_parameters(larger)]
    coarse = predictor.coarse_prediction([])
    ratios = ModificationScreen(coarse, []).ratios(sizes)
    assert ratios is not None
    without = predictor.predict([]).h[:: predictor.step]
    for size, ratio in zip(sizes, ratios, strict=True):
        predicted = predictor.predict([size]).h[:: predictor.step] / without
        np.testing.assert_allclose(ratio, predicted[coarse.observed.fitted], rtol=1e-4)


@pytest.mark.parametrize("level", [1.0, None])
def test_forces_of_a_changed_exciter_are_predicted_exactly(level: float | None) -> None:
    declared = rig(noise=QUIET)
    excitation = replace(declared.analyser.excitation, level=level)
    setup = replace(declared, analyser=replace(declared.analyser, excitation=excitation))
    predictor, _ = predicting(replace(draw_measurement(declared), setup=setup))
    coarse = predictor.coarse_prediction([])
    effects = [StingerAxial(None, 1e5, 0.1), StingerAxial(None, 1e6, 0.05), StingerAxial(None, 1e7)]
    found = ModificationScreen(coarse, []).residuals(effects)
    assert found is not None
    for vector, effect in zip(found, effects, strict=True):
        predicted = residual(coarse.observed, coarse.predict([effect]))
        start = 2 * int(coarse.observed.fitted.sum())
        n_force = predicted.sizes_by_part(coarse.observed.fitted)["force"]
        of_force = slice(start, start + n_force)
        expected = predicted.vector(coarse.observed.fitted)[of_force]
        # residuals of up to hundreds, of logarithms over their random error
        np.testing.assert_allclose(vector[of_force], expected, atol=1e-3)


def test_a_reading_that_mass_cancellation_subtracts_has_no_closed_form() -> None:
    setup = rig(noise=QUIET)
    cancelling = replace(setup, analyser=replace(setup.analyser, mass_cancellation=0.01))
    predictor, _ = predicting(draw_measurement(cancelling))
    screen = ModificationScreen(predictor.coarse_prediction([]), [])
    assert screen.residuals([GainError(Channels((Dof(1, "Y"),)), 1.1)]) is None
    assert screen.residuals([GroundSpring(Dof(3, "Y"), 1e4)]) is not None


def test_an_effect_that_has_no_closed_form_has_no_ratios() -> None:
    screen = ModificationScreen(quiet().coarse_prediction([]), [])
    for effect in (
        StiffnessError(None, 1.1),
        MisplacedAccelerometer(Channels((Dof(5, "Y"),)), 0.02),
        SwappedChannels(Channels((Dof(4, "Y"), Dof(5, "Y")))),
        CubicStiffness(Dof(5, "Y")),
        ForceNoise(None, 0.1),
        Leakage(None, 0.5),
    ):
        assert screen.ratios([effect]) is None
        assert screen.residuals([effect]) is None


def test_a_member_that_is_altered_already_is_left_to_a_prediction() -> None:
    predictor = quiet()
    accepted = StiffnessError(Members((3,)), 0.8)
    screen = ModificationScreen(predictor.coarse_prediction([accepted]), [accepted])
    assert screen.ratios([DensityError(Members((3,)), 1.1)]) is None


def test_residuals_of_a_ratio_are_those_of_the_prediction() -> None:
    predictor, _ = predicting(draw_measurement(rig(noise=QUIET), [ExtraMass(Dof(4, "Y"), 0.01)]))
    coarse = predictor.coarse_prediction([])
    screen = ModificationScreen(coarse, [])
    same = screen.vectors(np.ones((1, int(coarse.observed.fitted.sum())), complex))
    np.testing.assert_allclose(same[0], screen.unmodified, atol=1e-12)
