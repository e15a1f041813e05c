"""A roving hammer: the same is named as by a shaker, in whatever order the points were struck."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels, Members
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.localisation.evidence import collect_evidence
from modallab.diagnosis.predicting.held_out import select_held_out
from modallab.diagnosis.predicting.limitations import limitations
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.frf_selection import FrfSelection
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.result import Verdict
from modallab.diagnosis.result_localisation import GapPattern
from modallab.effects.gain_error import GainError
from modallab.effects.polarity import Polarity
from modallab.effects.stiffness_error import StiffnessError
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.hardware import Accelerometers, Exciter, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.rigs import dofs, steel_beam

SOFT = StiffnessError(Members((6,)), 0.8)
STRUCK = (1, 5, 9, 14, 21)
KINDS = ["stiffness_error", "extra_mass", "gain_error"]


def hammer(struck: Sequence[int], references: Sequence[int], *, roving: bool = False) -> RigSetup:
    """Return a rig with a hammer: 101 lines to 400 Hz, 30 blows a point."""
    return RigSetup(
        dofs(*struck),
        dofs(*references),
        exciter=Exciter("hammer"),
        accelerometers=Accelerometers(mass=0.01, roving=roving),
        noise=Noise(1e-4, 1e-4),
        analyser=Analyser(
            frequency_max=400.0, n_lines=101, averages=30, excitation=ExcitationSetting("impact")
        ),
    )


def struck_beam(
    setup: RigSetup, effects: Sequence[Effect] = (SOFT,), *, route: Route = Route.DRAWN
) -> Measurement:
    """Return a test of the beam of chapter 5."""
    return measure(steel_beam(), setup, effects, route=route, rng=np.random.default_rng(0))


@pytest.mark.parametrize("references", [(1,), (1, 9)])
def test_a_roving_hammer_names_the_element_that_a_shaker_names(references: Sequence[int]) -> None:
    shaken = replace(
        hammer((1,), STRUCK), exciter=Exciter(), analyser=Analyser(frequency_max=400.0, n_lines=101)
    )
    named = []
    for setup in (shaken, hammer(STRUCK, references)):
        found = diagnose(steel_beam(), struck_beam(setup), suspects=KINDS)
        assert found.verdict is Verdict.EXPLAINED
        (step,) = found.steps
        number = step.effect.parameters["factor"]
        # four standard errors, one time in 16,000 beyond
        assert abs(number.value - 0.8) < 4 * number.standard_error
        named.append((step.effect.kind, step.effect.at))
    assert named == [("stiffness_error", Members((6,)))] * 2


def test_the_order_of_the_drive_points_changes_nothing() -> None:
    setup = hammer((1, 5, 14), (1, 9))
    turned = replace(setup, drives=setup.drives[::-1])
    gaps, forces = [], []
    for test in (setup, turned):
        observed = observe(struck_beam(test, route=Route.EXPECTED), (), fraction=0.0)
        predictor = SingleTestPredictor.of(steel_beam(), test, observed)
        residual = predictor.residual(())
        gaps.append(residual.gaps(observed.usable))
        forces.append(np.sort(np.abs(residual.vector(observed.fitted))))
    assert gaps[0] == pytest.approx(gaps[1], rel=1e-9)  # rounding of sums in another order
    np.testing.assert_allclose(forces[0], forces[1], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("roving", [False, True])
def test_the_prediction_of_each_frf_is_the_measured_one(roving: bool) -> None:
    setup = hammer((1, 5, 14), (1, 9), roving=roving)
    observed = observe(struck_beam(setup, (), route=Route.EXPECTED), (), fraction=0.0)
    residual = SingleTestPredictor.of(steel_beam(), setup, observed).residual(())
    # one part in 1e-6, the least random error of any value: half of it is rounding of the receptances
    assert max(np.abs(part[1:]).max() for part in residual.parts.values()) < 0.5
    assert observed.force is not None
    assert observed.force.shape[1] == (6 if roving else 3)


@pytest.mark.parametrize("level", [1.0, 3.0])
def test_blows_of_a_level_that_nobody_declared_leave_random_error_alone(level: float) -> None:
    def at_level(size: float | None) -> RigSetup:
        setup = hammer((1, 5, 9), (1, 9))
        excitation = replace(setup.analyser.excitation, level=size)
        return replace(setup, analyser=replace(setup.analyser, excitation=excitation))

    test = replace(struck_beam(at_level(level), ()), setup=at_level(None))
    observed = observe(test, (), fraction=0.0)
    residual = SingleTestPredictor.of(steel_beam(), test.setup, observed).residual(())
    for gap in residual.gaps(observed.usable).values():
        # 100 lines of three runs have a mean square of 1 within 0.08: three standard deviations and more
        assert gap == pytest.approx(1.0, abs=0.3)


def test_a_point_struck_from_the_other_side_is_named() -> None:
    wrong = Polarity(Dof(14, "Y"))
    found = diagnose(steel_beam(), struck_beam(hammer(STRUCK, (1, 9)), [wrong]), suspects=["polarity"])
    (step,) = found.steps
    assert (step.effect.kind, step.effect.at) == ("polarity", Dof(14, "Y"))


def test_a_response_with_a_wrong_gain_is_named_from_all_its_runs() -> None:
    loud = GainError(Channels((Dof(9, "Y"),)), 1.1)
    found = diagnose(
        steel_beam(), struck_beam(hammer(STRUCK, (1, 9)), [loud]), suspects=["gain_error", "polarity"]
    )
    (step,) = found.steps
    assert (step.effect.kind, step.effect.at) == ("gain_error", Channels((Dof(9, "Y"),)))


def test_frfs_are_held_out_by_response_and_drive_point() -> None:
    test = struck_beam(hammer(STRUCK, (1, 9)))
    chosen, _ = select_held_out(steel_beam(), test, 0.25, (), 0)
    assert len(chosen) == 2
    assert all(frf.response is not None and frf.drive is not None for frf in chosen)
    assert FrfSelection(Dof(1, "Y"), Dof(1, "Y")) not in chosen
    named, unmeasured = select_held_out(steel_beam(), test, 0.0, (Dof(14, "Y"), Dof(3, "Y")), 0)
    assert named == [FrfSelection(drive=Dof(14, "Y"))]
    assert unmeasured == (Dof(3, "Y"),)
    observed = observe(test, named, fraction=0.25)
    assert [str(c) for c, out in zip(observed.channels, observed.held_out, strict=True) if out] == [
        "1:+Y / 14:+Y",
        "9:+Y / 14:+Y",
    ]


def test_curves_are_arranged_by_response_and_drive_point() -> None:
    test = struck_beam(hammer((1, 5, 14), (1, 9)))
    found = diagnose(steel_beam(), test, suspects=["stiffness_error"], hold_out=[Dof(5, "Y"), Dof(3, "Y")])
    curves = found.curves
    np.testing.assert_array_equal(curves.measured, test.frf.values)
    np.testing.assert_array_equal(curves.held_out, [[False, True, False]] * 2)
    assert curves.predicted is not None
    assert curves.predicted.shape == (101, 1, 3)
    assert [curves.by_frf.name(i) for i in (0, 1, 2)] == ["1:+Y / 1:+Y", "9:+Y / 1:+Y", "1:+Y / 5:+Y"]
    assert {(misfit.dof, misfit.drive) for misfit in found.located.responses} == {
        (response, drive) for response in test.frf.outputs for drive in test.frf.inputs
    }


def test_evidence_has_the_force_of_each_frf() -> None:
    test = struck_beam(hammer((1, 5, 14), (1, 9)))
    observed = observe(test, (), fraction=0.0)
    evidence = collect_evidence(SingleTestPredictor.of(steel_beam(), test.setup, observed), ())
    assert evidence.force is not None
    assert evidence.force.shape == evidence.frf.shape
    assert 0 <= EFFECTS["exciter_armature"].signature(evidence) <= 1  # compares the parts' gaps


def test_one_frf_that_disagrees_alone_is_said_to_be_one_frf() -> None:
    test = struck_beam(hammer(STRUCK, (1, 9)), ())
    values = test.frf.values.copy()
    values[:, 1, 3] *= 1.2
    found = diagnose(
        steel_beam(),
        replace(test, frf=replace(test.frf, values=values)),
        suspects=["extra_mass"],
        max_effects=1,
    )
    assert GapPattern.ONE_RESPONSE in found.located.signs
    assert (
        "only one FRF, 9:+Y / 14:+Y, disagrees; all others agree within random error and tolerances"
        in found.located.words
    )


def test_reciprocity_is_used_where_there_is_one_response_and_tested_where_there_are_pairs() -> None:
    def said(struck: Sequence[int], references: Sequence[int], scale: float = 1.0) -> str:
        setup = hammer(struck, references)
        test = struck_beam(setup, ())
        values = test.frf.values.copy()
        values[:, 0, 1] *= scale
        test = replace(test, frf=replace(test.frf, values=values))
        return " ".join(limitations(test, observe(test, (), fraction=0.0)))

    assert "by reciprocity as good as 5 responses" in said(STRUCK, (1,))
    assert "no two points were both struck and measured" in said((5, 14), (1, 9))
    assert "equal within random error" in said((1, 9), (1, 9))
    # 0.1 over 1.05 is 9.5 %, to the random error of the lines at the peaks
    assert "not reciprocal at 1 of 1 pair of points: 1:+Y and 9:+Y by 9." in said((1, 9), (1, 9), 1.1)
