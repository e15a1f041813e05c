"""Several tests of one structure explained at once."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.predicting.follow_up import FollowUp
from modallab.diagnosis.predicting.joint_prediction import JointPredictor
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.frf_selection import FrfSelection
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.residuals.predicted import SimulatedDeviations
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.force_transducer_mass import ForceTransducerMass
from modallab.effects.overload import Overload
from modallab.rig.change import Change
from modallab.rig.effect import Effect
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.diagnosing import draw_measurement, model, rig

MASS = ExtraMass(at=Dof(1, "Y"), mass=0.02)
MOVED = Change(drive=Dof(5, "Y"))


def together(*tests: Measurement, held: Sequence[Dof] = ()) -> JointPredictor:
    """Return the predictor of a first test and further ones."""
    seen = [observe(test, [FrfSelection(dof) for dof in held], fraction=0.0) for test in tests]
    first = SingleTestPredictor.of(model(), tests[0].setup, seen[0])
    rest = [first.follow_up(test.setup, one) for test, one in zip(tests[1:], seen[1:], strict=True)]
    return JointPredictor.of([first, *rest])


def both(setup: RigSetup, change: Change, hidden: Sequence[Effect] = (MASS,)) -> JointPredictor:
    """Return the predictor of a test and of a further one with a change."""
    return together(draw_measurement(setup, hidden), draw_measurement(change.applied(setup), hidden, seed=1))


def test_several_tests_leave_what_they_leave_each_for_itself() -> None:
    joint = both(rig(), MOVED)
    whole = joint.residual([MASS])
    parts = [test.residual([MASS]).vector(test.observed.usable) for test in joint.tests]
    alone = sum(float(part @ part) for part in parts)
    own = whole.vector(joint.observed.usable)
    assert len(own) == sum(map(len, parts))
    # rounding of a sum of some thousand squares
    assert float(own @ own) == pytest.approx(alone, rel=1e-12)


def test_a_second_drive_point_parts_what_one_cannot() -> None:
    joint = both(rig(), MOVED)
    first = joint.tests[0]
    gauge = ForceTransducerMass(mass=0.02)
    alone = [fit(first, [effect]).chi_square for effect in (MASS, gauge)]
    # One and the same mass at the one drive point: apart by no more than where a fit stops.
    assert alone[0] == pytest.approx(alone[1], abs=0.1)
    found = fit(joint, [MASS])
    assert found.chi_square / found.n_data == pytest.approx(1.0, abs=0.1)
    assert fit(joint, [gauge]).chi_square > 100 * found.chi_square


def test_two_tests_know_a_mass_better_than_one() -> None:
    joint = both(rig(), Change(averages_factor=4.0))
    one, two = fit(joint.tests[0], [MASS]), fit(joint, [MASS])
    ratio = two.errors[0]["mass"] / one.errors[0]["mass"]
    # Five times the averages in all: 1/sqrt(5) = 0.45, from errors that both fits estimate.
    assert ratio == pytest.approx(5**-0.5, rel=0.15)


def test_where_a_test_did_not_measure_nothing_is_usable() -> None:
    others = Change(responses=(Dof(1, "Y"), Dof(3, "Y"), Dof(8, "Y")))
    joint = both(rig(), others)
    seen = joint.observed
    assert [dof.node for dof in seen.outputs] == [1, 2, 4, 5, 7, 9, 3, 8]
    lines = len(seen.freq) // 2
    assert not seen.usable[:lines, 6:].any()
    assert not seen.usable[lines:, 1:6].any()
    assert seen.usable[lines + 1 :, [0, 6, 7]].all()
    left = joint.residual([MASS])
    assert all(gap == pytest.approx(1.0, abs=0.25) for gap in left.gaps(seen.usable).values())


def test_what_is_held_out_is_held_out_of_all_tests() -> None:
    hidden = [draw_measurement(setup, [MASS]) for setup in (rig(), MOVED.applied(rig()))]
    seen = together(*hidden, held=[Dof(4, "Y")]).observed
    assert seen.held_out.tolist() == [False, False, True, False, False, False]
    assert not seen.fitted[:, 2].any()


def test_first_looks_at_several_tests_are_those_at_each() -> None:
    joint = both(rig(kind="random", window="hann"), MOVED)
    coarse = joint.coarse_prediction([])
    predicted = coarse.predict([MASS])
    each = [test.coarse_prediction([]).predict([MASS]).h for test in joint.tests]
    np.testing.assert_allclose(predicted.h, np.concatenate(each), rtol=1e-12)
    assert coarse.observed.h.shape == predicted.h.shape


def test_lines_are_held_out_of_each_test_alike() -> None:
    joint = both(rig(), MOVED)
    lines = joint.without_lines(4).observed.held_out_lines
    half = len(lines) // 2
    np.testing.assert_array_equal(lines[:half], lines[half:])
    assert lines.sum() == pytest.approx(len(lines) / 4, abs=2)


def test_a_further_test_whose_log_book_was_not_rewritten_is_read_with_its_change() -> None:
    first = draw_measurement(rig())
    louder = Change(level_factor=3.0)
    uploaded = replace(draw_measurement(louder.applied(rig())), setup=rig())
    taken = FollowUp(uploaded, louder).with_consistent_log_book(first)
    assert taken.setup == louder.applied(rig())


def test_a_further_test_of_other_responses_than_it_says_is_refused() -> None:
    first = draw_measurement(rig())
    with pytest.raises(InvalidInputError) as refused:
        FollowUp(first, Change(responses=(Dof(1, "Y"), Dof(3, "Y")))).with_consistent_log_book(first)
    assert refused.value.context["field"] == "follow_ups.changed.responses"


def test_fixed_and_roving_accelerometers_are_not_put_together() -> None:
    with pytest.raises(InvalidInputError, match="roving"):
        FollowUp(draw_measurement(rig(roving=False))).with_consistent_log_book(draw_measurement(rig()))


def test_bursts_of_several_tests_are_draws_of_their_own() -> None:
    clipped = Overload(level=1.5)
    joint = both(rig(kind="random", window="hann"), Change(level_factor=2.0), (clipped,))

    def bursts(of: Predictor) -> SimulatedDeviations:
        found = of.simulate_variance((clipped,))
        assert found is not None
        assert found.deviations is not None
        return found.deviations

    for part, one, other in zip(bursts(joint), *map(bursts, joint.tests), strict=True):
        n = one.shape[1]
        np.testing.assert_array_equal(part[:, :n], one)
        np.testing.assert_array_equal(part[1:, n:], other[:-1], "the same seed drew them")


def test_a_test_without_bursts_leaves_none_to_go_through() -> None:
    assert both(rig(), Change(level_factor=2.0)).simulate_variance((MASS,)) is None
