"""A diagnosis from several tests of one structure."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnknownDofError
from modallab.core.place import Channels
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.predicting.follow_up import FollowUp
from modallab.diagnosis.predicting.joint_prediction import JointPredictor
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.result import Diagnosis, Verdict
from modallab.diagnosis.searching.suspects import Suspects
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.force_transducer_mass import ForceTransducerMass
from modallab.effects.gain_error import GainError
from modallab.effects.stinger_bending import StingerBending
from modallab.rig.change import Change
from modallab.rig.effect import Effect
from modallab.rig.effects_in_other_test import effects_in_other_test
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.diagnosing import model, rig

DRIVE = Dof(1, "Y")


def small() -> RigSetup:
    """Return a rig of four fixed accelerometers and few lines."""
    setup = rig(roving=False)
    analyser = replace(setup.analyser, n_lines=81, frequency_max=320.0)
    return replace(setup, responses=setup.responses[:4], analyser=analyser)


def drawn(setup: RigSetup, hidden: Sequence[Effect] = (), *, seed: int = 0) -> Measurement:
    """Return a measurement drawn as its signals scatter: a blow is the same every time."""
    return measure(model(), setup, hidden, route=Route.DRAWN, rng=np.random.default_rng(seed))


def taken(setup: RigSetup, change: Change, hidden: Sequence[Effect], *, seed: int = 1) -> FollowUp:
    """Return a further test of what the first one hides."""
    after = change.applied(setup)
    return FollowUp(drawn(after, effects_in_other_test(hidden, setup, after), seed=seed), change)


def found_by(
    setup: RigSetup, hidden: Sequence[Effect], *changes: Change, suspects: Sequence[str]
) -> Diagnosis:
    """Return the diagnosis of a test and of further ones."""
    further = [taken(setup, change, hidden, seed=i) for i, change in enumerate(changes, 1)]
    return diagnose(model(), drawn(setup, hidden), suspects=suspects, follow_ups=further)


@pytest.mark.parametrize(
    ("hidden", "change"),
    [
        (ExtraMass(at=DRIVE, mass=0.02), Change(drive=Dof(5, "Y"))),
        (ForceTransducerMass(mass=0.02), Change(drive=Dof(5, "Y"))),
    ],
    ids=["mass", "gauge"],
)
def test_a_further_test_decides_between_a_mass_and_the_gauges(hidden: Effect, change: Change) -> None:
    suspects = ("extra_mass", "force_transducer_mass")
    found = found_by(small(), [hidden], change, suspects=suspects)
    assert found.verdict is Verdict.EXPLAINED
    (step,) = found.steps
    assert (step.effect.kind, step.effect.at) == (hidden.kind, hidden.at)
    assert step.rivals_alike == ()
    assert found.next_test is None
    assert found.follow_ups == (change.plain,)


def test_a_stinger_is_told_from_a_spring_by_another_drive_point() -> None:
    hidden = StingerBending(stiffness=20.0, length=0.5)
    suspects = ("stinger_bending", "rotational_ground_spring")
    setup = small()
    assert found_by(setup, [hidden], suspects=suspects).verdict is Verdict.AMBIGUOUS
    found = found_by(setup, [hidden], Change(drive=Dof(5, "Y")), suspects=suspects)
    assert [step.effect.kind for step in found.steps] == ["stinger_bending"]
    assert found.verdict is Verdict.EXPLAINED


def test_nothing_is_missing_from_several_tests_that_the_model_predicts() -> None:
    changes = (Change(level_factor=3.0), Change(n_lines=61), Change(drive=Dof(9, "Y"), averages_factor=0.5))
    found = found_by(small(), [], *changes, suspects=("extra_mass",))
    assert found.verdict is Verdict.NOTHING_MISSING
    assert abs(found.remaining_gap - 1) < 4 * found.remaining_scatter


def test_each_transducer_of_the_further_tests_may_be_a_little_off_too() -> None:
    setup = small()
    elsewhere = Change(responses=(DRIVE, Dof(3, "Y"), Dof(6, "Y"), Dof(8, "Y")))
    after = elsewhere.applied(setup)
    one_percent = [GainError(at=Channels((Dof(6, "Y"),)), factor=1.01)]
    further = FollowUp(drawn(after, one_percent, seed=1), elsewhere)
    allowed = Tolerances(sensitivity=0.005)
    suspects = ("extra_mass", "gain_error")
    found = diagnose(model(), drawn(setup), suspects=suspects, follow_ups=[further], tolerances=allowed)
    assert found.verdict is Verdict.NOTHING_MISSING


def test_a_blow_is_explained_together_with_a_shaker() -> None:
    setup, gauge = small(), ForceTransducerMass(mass=0.02)
    struck = taken(setup, Change(exciter="hammer"), [gauge])
    first = SingleTestPredictor.of(model(), setup, observe(drawn(setup, [gauge]), (), fraction=0.0))
    further = struck.with_consistent_log_book(drawn(setup, [gauge]))
    joint = JointPredictor.of([first, first.follow_up(further.setup, observe(further, (), fraction=0.0))])
    usable = joint.observed.usable
    # The gauge is there in the first test alone. 80 lines of 4 channels scatter by 6 %, five of them 30 %.
    assert all(gap < 1.3 for gap in joint.residual([gauge]).gaps(usable).values())
    assert joint.residual([ExtraMass(at=DRIVE, mass=0.02)]).gap(usable) > 100


def test_what_shows_at_the_second_level_alone_is_suspected() -> None:
    setup = small()
    cubic = CubicStiffness(at=Dof(4, "Y"), stiffness=1e8)
    louder = Change(level_factor=10.0)
    further = taken(setup, louder, [cubic])
    first = SingleTestPredictor.of(model(), setup, observe(drawn(setup, [cubic]), (), fraction=0.0))
    loud = first.follow_up(further.measurement.setup, observe(further.measurement, (), fraction=0.0))
    candidates = Suspects([cubic, ExtraMass(at=Dof(4, "Y"))], least=0.1)
    assert CubicStiffness not in {type(one) for one in candidates.of(first, [])}
    assert CubicStiffness in {type(one) for one in candidates.of(JointPredictor.of([first, loud]), [])}


def test_a_long_fit_of_several_tests_is_heard_at_every_prediction() -> None:
    setup = small()
    told: list[tuple[float, str]] = []
    diagnose(
        model(),
        drawn(setup, [ExtraMass(at=Dof(4, "Y"), mass=0.01)]),
        suspects=("extra_mass",),
        follow_ups=[taken(setup, Change(level_factor=3.0), [ExtraMass(at=Dof(4, "Y"), mass=0.01)])],
        progress=lambda fraction, message: told.append((fraction, message)),
    )
    fitting = [said for said in told if said[1].startswith("fitting")]
    # A fit starts, goes and looks about it: each asks both tests for more than one prediction.
    assert len(fitting) >= 4 * len(set(fitting))
    assert [fraction for fraction, _ in told] == sorted(fraction for fraction, _ in told)


def test_curves_are_those_of_the_first_test() -> None:
    elsewhere = Change(responses=(DRIVE, Dof(3, "Y"), Dof(8, "Y")))
    setup = small()
    found = found_by(setup, [], elsewhere, suspects=("extra_mass",))
    assert found.curves.outputs == setup.responses


def test_a_further_test_that_contradicts_its_log_book_is_refused() -> None:
    setup = small()
    louder = drawn(Change(level_factor=2.0).applied(setup))
    with pytest.raises(InvalidInputError, match="contradicts"):
        diagnose(model(), drawn(setup), follow_ups=[FollowUp(louder, Change(level_factor=3.0))])


def test_a_further_test_where_the_model_has_no_dof_is_refused() -> None:
    setup = small()
    after = Change(responses=(DRIVE, Dof(99, "Y"))).applied(setup)
    with pytest.raises((UnknownDofError, InvalidInputError)):
        diagnose(
            model(), drawn(setup), follow_ups=[FollowUp(drawn(setup), Change(responses=after.responses))]
        )
