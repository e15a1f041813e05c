"""Where a gap sits: in modes, responses, bands and parts, as numbers and in words."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels, Members
from modallab.diagnosis.localisation.evidence import collect_evidence
from modallab.diagnosis.localisation.locate import locate
from modallab.diagnosis.predicting.follow_up import FollowUp
from modallab.diagnosis.predicting.joint_prediction import JointPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.result_localisation import ChannelError, GapPattern, Localisation
from modallab.effects.channel_delay import ChannelDelay
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.gain_error import GainError
from modallab.effects.ground_spring import GroundSpring
from modallab.effects.loss_factor_error import LossFactorError
from modallab.effects.mains_hum import MainsHum
from modallab.effects.polarity import Polarity
from modallab.effects.response_noise import ResponseNoise
from modallab.effects.stiffness_error import StiffnessError
from modallab.effects.swapped_channels import SwappedChannels
from modallab.fe.assembly import assemble
from modallab.rig.change import Change
from modallab.rig.effect import Effect
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.diagnosing import draw_measurement, model, predicting, rig


def located(effects: list[Effect], setup: RigSetup | None = None, seed: int = 1) -> Localisation:
    predictor, _ = predicting(draw_measurement(setup or rig(), effects, seed=seed))
    return locate(predictor, collect_evidence(predictor, []))


def at(node: int) -> Channels:
    return Channels((Dof(node, "Y"),))


def said(found: Localisation, text: str) -> bool:
    return any(text in words for words in found.words)


def test_bands_and_modes_are_where_the_gap_is() -> None:
    predictor, _ = predicting(draw_measurement(rig(), [StiffnessError(factor=1.02)]))
    evidence = collect_evidence(predictor, [])
    found = locate(predictor, evidence)
    worst = evidence.freq[evidence.by_line.argmax()]
    nearest = int(np.abs(evidence.mode_frequency - worst).argmin()) + 1
    assert nearest in found.modes
    assert any(low <= worst <= high for low, high in found.bands)


# Shifts of poles as the model has them; the errors told are those of the draw and of one mode and a line.
@pytest.mark.parametrize(
    "hidden",
    [
        StiffnessError(at=Members((3,)), factor=0.8),
        ExtraMass(at=Dof(4, "Y"), mass=0.03),
        LossFactorError(factor=1.5),
    ],
    ids=lambda effect: effect.kind,
)
@pytest.mark.parametrize(("kind", "window"), [("periodic_random", "rectangular"), ("random", "hann")])
def test_shifts_of_modes_are_those_of_the_eigenvalues(hidden: Effect, kind: str, window: str) -> None:
    # fixed and light accelerometers: all runs have the same modes
    setup = rig(kind=kind, window=window, roving=False, averages=400, noise=1e-5)
    setup = replace(setup, accelerometers=replace(setup.accelerometers, mass=0.0))
    found = located([hidden], replace(setup, analyser=replace(setup.analyser, n_lines=801)))
    bare = assemble(model()).add_mass(1, 0.01)  # the force transducer's
    before, after = (
        one.modes().elastic(4) for one in (bare, hidden.on_system(bare, setup.acquisition_runs[0]))
    )
    assert [one.mode for one in found.mode_shifts] == [1, 2, 3, 4]
    for i, one in enumerate(found.mode_shifts):
        frequency = after.frequencies[i] / before.frequencies[i] - 1
        # four standard errors, and what leakage does to two resonances that lie differently between lines
        leaked = 1e-4 if kind == "random" else 2e-5
        assert abs(one.frequency_shift - frequency) < 4 * one.frequency_error + leaked
        loss = after.loss_factors[i] / before.loss_factors[i] - 1
        if kind == "periodic_random":
            assert abs(one.loss_factor_shift - loss) < 4 * one.loss_factor_error + 5e-3
        assert one.frequency_error < 1e-3


def test_what_all_modes_have_in_common_is_said_once() -> None:
    found = located([StiffnessError(factor=1.02)])
    assert said(found, "the natural frequencies are higher than the model's, all by about 0.99 %")
    soft = located([GroundSpring(at=Dof(1, "Y"), stiffness=500.0)])
    assert said(soft, "the shift grows towards lower modes")


def test_modes_of_swapped_channels_have_not_moved() -> None:
    found = located([SwappedChannels(at=Channels((Dof(2, "Y"), Dof(7, "Y"))))])
    assert all(abs(one.frequency_shift) < 5 * one.frequency_error for one in found.mode_shifts)
    assert not said(found, "mode 1")
    assert set(found.dofs) == {Dof(2, "Y"), Dof(7, "Y")}


@pytest.mark.parametrize(
    ("hidden", "course", "words"),
    [
        (GainError(at=at(5), factor=1.1), ChannelError.GAIN, "5:+Y reads 10 % high at all frequencies"),
        (Polarity(at=at(5)), ChannelError.POLARITY, "5:+Y has the opposite sign"),
        (ChannelDelay(at=at(5), delay=3e-5), ChannelError.DELAY, "5:+Y lags by"),
    ],
    ids=lambda value: getattr(value, "kind", ""),
)
def test_a_channel_error_of_one_response_is_named(hidden: Effect, course: ChannelError, words: str) -> None:
    found = located([hidden])
    assert found.signs == (GapPattern.ONE_RESPONSE,)
    (one,) = [one for one in found.responses if one.course is not None]
    assert (one.dof, one.course) == (Dof(5, "Y"), course)
    assert said(found, words)
    others = [one for one in found.responses if one.dof != Dof(5, "Y")]
    # 160 complex residuals scatter by 8 %: four of these
    assert all(abs(one.gap - 1) < 0.4 for one in others)
    if course is ChannelError.GAIN:
        # lines weigh by their errors, which blend to the difference of numbers where those are coarse
        assert abs(one.amplitude - 1.1) < 4 * one.amplitude_error + 1e-3
    if course is ChannelError.DELAY:
        assert abs(one.delay - 3e-5) < 4 * one.delay_error


def test_a_drive_point_that_stands_out_is_called_so() -> None:
    assert located([GainError(at=at(1), factor=1.05)]).signs == (GapPattern.DRIVE_POINT_ONLY,)


def test_forces_alone_are_told() -> None:
    found = located([ExciterArmature(mass=0.05)])
    assert found.signs == (GapPattern.FORCE_ONLY,)
    assert said(found, "only the auto spectra")
    assert found.mode_shifts == ()


def test_a_loss_of_coherence_alone_is_told() -> None:
    found = located([ResponseNoise(ratio=1e-3)])
    assert found.signs == (GapPattern.COHERENCE_ONLY,)
    assert said(found, "not coherent with the force is larger")


def test_bands_of_hum_are_its_lines() -> None:
    found = located([MainsHum(ratio=0.01, frequency=50.0)])
    assert found.signs == (GapPattern.COHERENCE_ONLY,)
    assert all(
        any(abs(hum - (low + high) / 2) < 5.0 for hum in (50, 150, 250, 350)) for low, high in found.bands
    )
    assert found.bands


def test_a_gap_at_one_end_of_the_band_is_told() -> None:
    found = located([GroundSpring(at=Dof(5, "Y"), stiffness=1e4)])
    assert GapPattern.LOW_FREQUENCY in found.signs
    assert said(found, "only the low end of the band disagrees")


def test_nothing_is_told_where_nothing_is_missing() -> None:
    found = located([], seed=4)
    assert (found.bands, found.dofs, found.modes, found.signs, found.mode_shifts) == ((), (), (), (), ())
    assert [words.split(":")[0] for words in found.words] == ["mean squared residual"]
    assert found.level_dependence is None


def _at_level(level: float, effects: list[Effect], seed: int) -> Measurement:
    setup = rig()
    excitation = replace(setup.analyser.excitation, level=level)
    return draw_measurement(
        replace(setup, analyser=replace(setup.analyser, excitation=excitation)), effects, seed=seed
    )


@pytest.mark.parametrize(
    ("effects", "dependent"), [([], False), ([ExtraMass(at=Dof(4, "Y"), mass=0.001)], True)]
)
def test_tests_at_two_levels_tell_whether_frfs_depend_on_it(effects: list[Effect], dependent: bool) -> None:
    first = _at_level(1.0, [], 1)
    # a mass that is there at the higher level only stands for what changes with it
    second = FollowUp(_at_level(3.0, effects, 2), Change(level_factor=3.0)).with_consistent_log_book(first)
    one, _ = predicting(first)
    other = one.follow_up(second.setup, observe(second, (), fraction=0.0))
    found = locate(JointPredictor.of([one, other]), collect_evidence(one, []))
    assert found.level_dependence is not None
    assert (found.level_dependence > 3) == dependent
    assert (GapPattern.LEVEL_DEPENDENCE in found.signs) == dependent
    if not dependent:
        # 960 complex numbers: 3 %; four of these
        assert found.level_dependence == pytest.approx(1.0, abs=0.15)
