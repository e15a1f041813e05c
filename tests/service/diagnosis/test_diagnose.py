from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

import modallab.diagnosis.diagnose as module
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.place import Members
from modallab.diagnosis.diagnose import diagnose, diagnose_with_options
from modallab.diagnosis.options import DiagnosisOptions
from modallab.diagnosis.result import UnknownCause, Verdict
from modallab.effects.accelerometer_mass import AccelerometerMass
from modallab.effects.attached_oscillator import AttachedOscillator
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.force_noise import ForceNoise
from modallab.effects.leakage import Leakage
from modallab.effects.polarity import Polarity
from modallab.effects.response_noise import ResponseNoise
from modallab.effects.stiffness_error import StiffnessError
from modallab.effects.stinger_bending import StingerBending
from modallab.fe.assembly import assemble
from modallab.fe.structure import PLANE
from modallab.rig.chain import chain
from modallab.rig.effect import Effect
from modallab.rig.expected import expected_spectra
from modallab.rig.measure import measurement_of
from modallab.rig.wishart import wishart_spectra
from tests.diagnosing import draw_measurement, exact, model, rig


@pytest.mark.parametrize(
    "hidden",
    [
        StiffnessError(at=Members((6,)), factor=0.8),
        # Four parts in a thousand everywhere move every resonance by a good part of its width.
        StiffnessError(at=None, factor=1.004),
        StiffnessError(at=None, factor=0.96),
        ExtraMass(at=Dof(4, "Y"), mass=0.03),
        AccelerometerMass(mass=0.004),
        ExciterArmature(mass=0.02),
        ResponseNoise(ratio=1e-4),
        ForceNoise(ratio=1e-3),
        Leakage(share=0.02),
    ],
    ids=lambda effect: effect.kind,
)
def test_a_hidden_effect_is_named_sized_and_closes_the_gap(hidden: Effect) -> None:
    found = diagnose(model(), draw_measurement(rig(), [hidden]))
    assert found.verdict is Verdict.EXPLAINED
    (step,) = found.steps
    assert (step.effect.kind, step.effect.at) == (hidden.kind, hidden.at)
    for name, parameter in step.effect.parameters.items():
        assert abs(parameter.value - hidden.parameters[name]) < 4 * parameter.standard_error
    assert step.gap_after < step.gap_before
    # 160 lines, one or two held-out FRFs: the scatter of a mean square is 6 %, four of them 25 %.
    assert step.held_out_gap_after < 1.25
    # A cable that loses nothing is an accelerometer's mass as well: its second number alone, which tells
    # nothing, speaks against it, by a factor of sqrt(3840 data) = 62.
    assert step.probability > 1 - 1.2 / 62


def test_a_hidden_effect_is_named_in_leaking_data() -> None:
    hidden = ExtraMass(at=Dof(7, "Y"), mass=0.02)
    found = diagnose(
        model(),
        draw_measurement(rig(kind="random", window="hann"), [hidden]),
        suspects=["extra_mass", "accelerometer_mass", "response_noise"],
    )
    assert found.steps[0].effect.at == hidden.at


def test_a_noise_free_test_is_explained_too() -> None:
    hidden = StiffnessError(at=Members((3,)), factor=1.3)
    found = diagnose(model(), exact(rig(noise=0.0), [hidden]))
    assert found.verdict is Verdict.EXPLAINED
    assert found.steps[0].effect.at == hidden.at
    assert found.steps[0].effect.parameters["factor"].value == pytest.approx(1.3, rel=1e-6)


def test_nothing_is_named_where_nothing_is_missing() -> None:
    found = diagnose(model(), draw_measurement(rig(), seed=3))
    assert found.verdict is Verdict.NOTHING_MISSING
    assert found.steps == ()
    assert abs(found.remaining_gap - 1) < 4 * found.remaining_scatter


def test_both_of_a_pair_are_named() -> None:
    hidden = [StiffnessError(at=Members((2,)), factor=1.3), ExciterArmature(mass=0.03)]
    found = diagnose(model(), draw_measurement(rig(), hidden))
    assert found.verdict is Verdict.EXPLAINED
    assert {step.effect.kind for step in found.steps} == {"stiffness_error", "exciter_armature"}


def test_what_no_suspect_explains_is_called_unexplained() -> None:
    hidden = StiffnessError(at=Members((4,)), factor=1.5)
    found = diagnose(
        model(), draw_measurement(rig(), [hidden]), suspects=["exciter_armature", "response_noise"]
    )
    assert found.verdict is Verdict.UNEXPLAINED
    assert found.remaining_gap > 10


def test_a_mass_at_the_drive_point_cannot_be_told_from_the_transducers() -> None:
    found = diagnose(model(), draw_measurement(rig(), [ExtraMass(at=Dof(1, "Y"), mass=0.02)]))
    assert found.verdict is Verdict.AMBIGUOUS
    named = {found.steps[0].effect.kind, *(alias.kind for alias in found.steps[0].rivals_alike)}
    assert named == {"extra_mass", "force_transducer_mass"}
    assert found.next_test is not None
    assert set(found.next_test.separates) == named


def test_what_is_added_makes_the_model_the_truth() -> None:
    hidden = StiffnessError(at=Members((6,)), factor=0.8)
    found = diagnose(model(), exact(rig(), [hidden]), suspects=["stiffness_error"])
    true = hidden.added_to(model())
    modes = [assemble(s).modes().elastic(6).frequencies for s in (found.structure, true)]
    np.testing.assert_allclose(modes[0], modes[1], rtol=1e-6)  # the fit's own tolerance


def test_a_rig_effect_goes_into_the_log_book() -> None:
    found = diagnose(model(), draw_measurement(rig(), [ExciterArmature(mass=0.02)]))
    assert [spec.kind for spec in found.setup.effects] == ["exciter_armature"]
    again = diagnose(
        model(), replace(draw_measurement(rig(), [ExciterArmature(mass=0.02)]), setup=found.setup)
    )
    assert again.verdict is Verdict.NOTHING_MISSING


def test_an_unmeasured_response_is_predicted_with_what_was_added() -> None:
    hidden = ExtraMass(at=Dof(4, "Y"), mass=0.03)
    there = Dof.parse("6:+Y")
    found = diagnose(model(), draw_measurement(rig(), [hidden]), suspects=["extra_mass"], hold_out=[there])
    truth = exact(replace(rig(noise=0.0), responses=(there,)), [hidden]).frf.values
    assert found.curves.predicted is not None
    assert found.curves.predicted_outputs == (there,)
    # The mass is known to 1e-4 of itself; its resonances move by less than 1e-5 and steep flanks
    # (loss factor 0.008) turn that into a few parts in a thousand.
    np.testing.assert_allclose(found.curves.predicted[1:], truth[1:], rtol=5e-3)


def test_the_place_of_the_gap_is_told_for_an_armature() -> None:
    found = diagnose(
        model(), draw_measurement(rig(), [ExciterArmature(mass=0.05)]), suspects=["exciter_armature"]
    )
    assert any("only the auto spectra" in words for words in found.located.words)


def test_the_same_seed_gives_the_same_diagnosis() -> None:
    measurement = draw_measurement(rig(), [ResponseNoise(ratio=1e-4)])
    first, second = (diagnose(model(), measurement, suspects=["response_noise"], seed=5) for _ in "ab")
    assert first.steps == second.steps


def test_progress_rises_to_the_end() -> None:
    told: list[float] = []
    diagnose(
        model(),
        draw_measurement(rig(), [ResponseNoise(ratio=1e-4)]),
        suspects=["response_noise"],
        progress=lambda fraction, _: told.append(fraction),
    )
    assert told == sorted(told)
    assert told[-1] <= 1


def test_no_suspects_are_refused_by_name() -> None:
    with pytest.raises(InvalidInputError) as refused:
        diagnose(model(), draw_measurement(rig()), suspects=[])
    assert refused.value.context["field"] == "suspects"


@pytest.mark.parametrize("fraction", [-0.1, 0.9, float("nan")])
def test_a_hold_out_of_most_frfs_is_refused(fraction: float) -> None:
    with pytest.raises(InvalidInputError) as refused:
        diagnose(model(), draw_measurement(rig()), hold_out_fraction=fraction)
    assert refused.value.context["field"] == "hold_out.fraction"


def test_where_something_stays_unexplained_no_effect_is_sure() -> None:
    found = diagnose(
        model(), draw_measurement(rig(), [ExtraMass(Dof(4, "Y"), 0.05)]), suspects=["gain_error"]
    )
    assert found.verdict is Verdict.UNEXPLAINED
    assert all(step.probability <= 0.5 for step in found.steps)


@pytest.mark.parametrize(("loss_factor", "damping_ratio"), [(0.05, 0.0), (1e-6, 0.03)])
def test_an_oscillator_is_told_with_the_kind_of_its_damping(loss_factor: float, damping_ratio: float) -> None:
    hidden = AttachedOscillator(Dof(4, "Y"), 0.03, 120.0, loss_factor, damping_ratio)
    found = diagnose(
        model(),
        draw_measurement(rig(), [hidden]),
        suspects=["attached_oscillator", "extra_mass"],
        max_effects=1,
    )
    assert found.verdict is Verdict.EXPLAINED
    (step,) = found.steps
    assert (step.effect.kind, step.effect.at) == ("attached_oscillator", hidden.at)
    for name, value in (("mass", 0.03), ("frequency", 120.0), ("damping_ratio", damping_ratio)):
        fitted = step.effect.parameters[name]
        # four standard errors; without a damper the fit has none, and no error of it
        assert abs(fitted.value - value) <= 4 * fitted.standard_error, name


def test_a_stinger_with_flexures_is_no_rotational_spring() -> None:
    """Turning and lateral motion are restrained apart, along a beam that slopes: 3 to 4."""
    straight = model()
    tilted = {node: (0.8 * x, 0.6 * x) for node, (x, _) in straight.nodes.items()}
    structure = replace(straight, nodes=tilted, directions=PLANE)
    hidden = StingerBending(stiffness=160.0, length=0.64, coupling=0.0)
    spectra = expected_spectra(chain(assemble(structure), rig(), [hidden]))
    test = measurement_of(wishart_spectra(spectra, np.random.default_rng(0)), rig())
    found = diagnose(structure, test, suspects=["stinger_bending", "rotational_ground_spring"])
    assert found.verdict is Verdict.EXPLAINED
    (step,) = found.steps
    assert step.effect.kind == "stinger_bending"
    for name, parameter in step.effect.parameters.items():
        error = 4 * parameter.standard_error  # four standard errors; of the coupling, a choice, none
        assert abs(parameter.value - hidden.parameters[name]) <= error


def test_a_stinger_on_a_beam_that_moves_across_only_comes_before_the_same_spring() -> None:
    """Its length does not enter, and counts as no parameter; a rig changes from test to test."""
    hidden = StingerBending(stiffness=100.0)
    found = diagnose(
        model(), draw_measurement(rig(), [hidden]), suspects=["rotational_ground_spring", hidden.kind]
    )
    assert found.verdict is Verdict.AMBIGUOUS
    (step,) = found.steps
    assert (step.effect.kind, step.effect.at) == (hidden.kind, None)
    assert [(rival.kind, rival.at) for rival in step.rivals_alike] == [
        ("rotational_ground_spring", Dof(1, "RZ"))
    ]
    stiffness = step.effect.parameters["stiffness"]
    assert abs(stiffness.value - hidden.stiffness) < 4 * stiffness.standard_error  # four standard errors


def test_effects_of_all_channels_that_imitate_an_unknown_one_explain_no_part() -> None:
    """A delay and a high-pass filter turn signs by about half a turn: a part, it was said."""
    test = draw_measurement(rig(), [Polarity(None)])
    options = DiagnosisOptions(suspects=("channel_delay", "ac_coupling"), max_effects=2)
    found = diagnose_with_options(model(), test, options)
    assert found.unknown is not None
    assert found.unknown.cause is UnknownCause.COMMON_GAIN
    assert found.verdict is Verdict.UNEXPLAINED


@pytest.mark.parametrize(
    ("left", "rivals", "verdict"),
    [
        (0.003, (), Verdict.PARTLY_EXPLAINED),
        (0.05, (), Verdict.UNEXPLAINED),
        (0.003, ("gain_error",), Verdict.UNEXPLAINED),
    ],
)
def test_a_part_is_explained_if_the_first_effect_alone_leaves_little(
    monkeypatch: pytest.MonkeyPatch, left: float, rivals: tuple[str, ...], verdict: Verdict
) -> None:
    """A mass and a gain at one point were said to be a part of a joint there that was no suspect."""
    first, second = Mock(fit="with the first"), Mock(fit="with both")
    ratios = {"with the first": left, "with both": 0.0}
    monkeypatch.setattr(module, "excess_ratio", lambda _, after, __: ratios[after])
    path = Mock(steps=[first, second], fit="with both")
    steps = [Mock(rivals_alike=rivals), Mock(rivals_alike=())]
    assert module._verdict(Mock(), path, steps, explained=False) is verdict
