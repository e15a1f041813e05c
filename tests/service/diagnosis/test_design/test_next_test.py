"""The known table of look-alikes: which further test is proposed, and whether it keeps its promise."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.progress import silent
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.optimisation.nuisance_parameters import nuisance_parameters
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.predicting.joint_prediction import JointPredictor
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.result import NextTest
from modallab.diagnosis.test_design.follow_up_tests import follow_up_options
from modallab.diagnosis.test_design.next_test import Explanation, propose
from modallab.diagnosis.test_design.settings import SEPARATION
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.force_transducer_mass import ForceTransducerMass
from modallab.effects.ground_spring import GroundSpring
from modallab.effects.joint_flexibility import JointFlexibility
from modallab.effects.rotational_ground_spring import RotationalGroundSpring
from modallab.effects.stiffness_error import StiffnessError
from modallab.effects.stinger_bending import StingerBending
from modallab.rig.change import Change
from modallab.rig.effect import Effect
from modallab.rig.setup import RigSetup
from tests.diagnosing import draw_measurement, model, predicting, rig

DRIVE = Dof(1, "Y")
MASS, GAUGE = ExtraMass(at=DRIVE, mass=0.02), ForceTransducerMass(mass=0.02)


def explained(predictor: Predictor, *effects: Effect) -> list[Fit]:
    """Return the fits of each effect alone."""
    return [fit(predictor, [effect]) for effect in effects]


def proposed(setup: RigSetup, hidden: Effect, rival: Effect, *, done: tuple[Change, ...] = ()) -> NextTest:
    """Return the test that is proposed where both explain what one of them did."""
    predictor, _ = predicting(draw_measurement(setup, [hidden]))
    best, other = (Explanation(f.effects, f.effects[0].kind) for f in explained(predictor, hidden, rival))
    test = propose(predictor, best, [other], previous_changes=done, progress=silent)
    assert test is not None
    assert test.separates == (hidden.kind, rival.kind)
    assert test.expected_separation >= SEPARATION.certain
    return test


def test_a_second_level_tells_a_cubic_spring_from_one_to_the_ground() -> None:
    cubic = CubicStiffness(at=Dof(4, "Y"), stiffness=1e9)
    test = proposed(rig(noise=1e-3), cubic, GroundSpring(at=Dof(4, "Y"), stiffness=30.0))
    assert test.change == {"level_factor": 3.0}
    assert "nonlinear" in test.why


def test_a_mass_is_told_from_that_of_the_gauge_by_another_drive_point_or_a_hammer() -> None:
    change = proposed(rig(), MASS, GAUGE).change
    assert "drive" in change or change == {"exciter": "hammer"}


def test_a_stinger_is_told_from_a_rotational_spring_by_another_drive_point_or_a_hammer() -> None:
    stinger = StingerBending(stiffness=20.0, length=0.5)
    spring = RotationalGroundSpring(at=Dof(1, "RZ"), stiffness=20.0)
    change = proposed(rig(), stinger, spring).change
    assert "drive" in change or change == {"exciter": "hammer"}


def test_what_was_done_already_is_not_proposed_again() -> None:
    first = proposed(rig(), MASS, GAUGE)
    again = proposed(rig(), MASS, GAUGE, done=(Change.read(first.change),))
    assert again.change != first.change


def test_the_expected_separation_is_what_the_test_shows_whichever_is_right() -> None:
    # So light that chi-square is quadratic over its error, and the rivals are told by no more than some.
    hidden, rival = ExtraMass(at=DRIVE, mass=2e-5), ForceTransducerMass(mass=2e-5)
    predictor, _ = predicting(draw_measurement(rig(), [hidden], seed=1))
    fits = explained(predictor, hidden, rival)
    best, other = (Explanation(one.effects, one.effects[0].kind) for one in fits)
    test = propose(predictor, best, [other], progress=silent)
    assert test is not None
    after = Change.read(test.change).applied(rig())
    shown = []
    for true in (hidden, rival):
        seen = observe(draw_measurement(after, [true], seed=1), (), fraction=0.0)
        joint = JointPredictor.of([predictor, predictor.follow_up(after, seen)])
        left = [one.chi_square for one in explained(joint, hidden, rival)]
        shown.append(np.sqrt(abs(left[1] - left[0])))
    # The difference of two chi-squares that are d^2 apart scatters by 2 d, its root by one; the masses
    # that the forecast starts from are known to a tenth, which counts for another one.
    assert min(shown) == pytest.approx(test.expected_separation, abs=3.0)


def test_two_names_of_one_thing_are_not_promised_to_be_told_apart() -> None:
    predictor, _ = predicting(draw_measurement(rig(), [MASS]))
    (found,) = explained(predictor, MASS)
    one = Explanation(found.effects, "extra_mass")
    assert propose(predictor, one, [one], progress=silent) is None


def test_no_test_is_proposed_for_what_is_tolerated() -> None:
    # A third of a standard deviation of the modulus: a further test moves that number, and tells nothing.
    setup = rig()
    stiff = StiffnessError(factor=1.001)
    predictor, _ = predicting(draw_measurement(setup, [stiff]))
    allowed = predictor.with_nuisances(
        nuisance_parameters(Tolerances(modulus=0.003), predictor.system, setup)
    )
    strict, lax = (
        propose(one, _explaining(fit(one, [stiff])), [_explaining(fit(one, []))], progress=silent)
        for one in (predictor, allowed)
    )
    assert strict is not None
    assert strict.expected_separation > SEPARATION.certain
    assert lax is None


def _explaining(found: Fit) -> Explanation:
    kind = found.effects[0].kind if found.effects else "nothing"
    return Explanation(found.effects, kind, found.nuisance_position)


def test_what_is_tolerated_makes_no_separation_larger() -> None:
    setup = rig()
    predictor, _ = predicting(draw_measurement(setup, [MASS]))
    best, other = (Explanation(f.effects, f.effects[0].kind) for f in explained(predictor, MASS, GAUGE))
    tolerances = Tolerances(modulus=0.003, sensitivity=0.005, modal_loss_factor=0.2)
    allowed = predictor.with_nuisances(nuisance_parameters(tolerances, predictor.system, setup))
    tests = [propose(one, best, [other], progress=silent) for one in (predictor, allowed)]
    sharp, blunt = (test.expected_separation for test in tests if test is not None)
    assert SEPARATION.certain < blunt < sharp


def test_a_hammer_is_not_proposed_to_who_has_one() -> None:
    struck = Change(exciter="hammer").applied(rig())
    predictor = SingleTestPredictor.of(model(), struck, observe(draw_measurement(struck), (), fraction=0.0))
    changes = [test.change for test in follow_up_options(predictor.setup, predictor.system)]
    assert all(change.exciter is None for change in changes)
    assert all(change.drive != struck.drive for change in changes)


def test_a_choice_between_two_values_is_no_parameter_that_a_test_would_separate() -> None:
    crack = JointFlexibility(Dof(4, "RZ"), 1e-4)
    (((perturbed,), step),) = Explanation((crack,), crack.kind).perturbed
    assert perturbed == JointFlexibility(Dof(4, "RZ"), 1e-4 + step)
