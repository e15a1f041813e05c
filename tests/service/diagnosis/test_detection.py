"""Tests of detection limits: effects hidden above them are named, those far below are not seen."""

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import Place
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.optimisation.tolerances import NO_TOLERANCES, Tolerances
from modallab.diagnosis.reporting.report import report
from modallab.diagnosis.result import DetectionLimit, Diagnosis, Verdict
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.loss_factor_error import LossFactorError
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.measure import Route, measure
from tests.diagnosing import model, rig

KINDS = ["extra_mass", "stiffness_error", "gain_error", "exciter_armature", "cubic_stiffness"]


def diagnosed(
    hidden: Sequence[Effect], *, seed: int = 0, averages: int = 100, tolerances: Tolerances = NO_TOLERANCES
) -> Diagnosis:
    test = measure(
        model(), rig(averages=averages), hidden, route=Route.DRAWN, rng=np.random.default_rng(seed)
    )
    return diagnose(model(), test, suspects=KINDS, tolerances=tolerances)


@cache
def limits(averages: int = 100, modulus: float = 0.0) -> dict[str, DetectionLimit]:
    found = diagnosed([], averages=averages, tolerances=Tolerances(modulus=modulus))
    assert found.verdict is Verdict.NOTHING_MISSING
    return {limit.kind: limit for limit in found.detection_limits}


def of_amount(limit: DetectionLimit, share: float, *, at: Place, amount: float) -> Effect:
    cls = EFFECTS[limit.kind]
    neutral = cls.specs()[limit.parameter].absent or 0.0
    return cls(at=at).with_parameters({limit.parameter: neutral + share * amount})


@pytest.mark.parametrize("kind", ["extra_mass", "stiffness_error", "gain_error", "exciter_armature"])
@pytest.mark.parametrize("most_visible", [True, False])
def test_an_effect_above_its_limit_is_named_and_one_far_below_is_not_seen(
    kind: str, most_visible: bool
) -> None:
    limit = limits()[kind]
    at, amount = (limit.at, limit.smallest) if most_visible else (limit.least_visible_at, limit.largest)
    for seed in range(2):
        # twice the amount has four times the gain in chi-square: beyond chance, and told from its rivals
        above = diagnosed([of_amount(limit, 2.0, at=at, amount=amount)], seed=seed)
        assert above.steps[0].effect.kind == kind
        # an eleventh of the gain: below the limit without its two standard deviations of margin
        below = diagnosed([of_amount(limit, 0.3, at=at, amount=amount)], seed=seed)
        assert below.verdict is Verdict.NOTHING_MISSING


def test_limits_fall_with_the_root_of_the_averages() -> None:
    few, many = limits(averages=100), limits(averages=400)
    for kind in ("extra_mass", "stiffness_error"):
        # noise of 1e-4, so that coherence is that of the averages; gaps differ by their own scatter
        assert few[kind].smallest / many[kind].smallest == pytest.approx(2.0, rel=0.1)


def test_tolerances_raise_the_limit_of_what_they_take_up() -> None:
    exact, tolerant = limits(), limits(modulus=0.003)
    everywhere, one = exact["stiffness_error"], tolerant["stiffness_error"]
    assert everywhere.at is None
    # that of all members is hidden by the tolerance, so that a single member is the most visible place
    assert one.at is not None
    assert one.smallest > 3 * everywhere.smallest
    assert tolerant["gain_error"].smallest == pytest.approx(exact["gain_error"].smallest, rel=0.2)


def test_what_the_tolerance_of_each_mode_takes_up_is_below_its_limit() -> None:
    """To first order modal loss factors are all that a loss factor error changes; its curvature is not."""

    def among_losses(hidden: Sequence[Effect]) -> Diagnosis:
        test = measure(model(), rig(), hidden, route=Route.DRAWN, rng=np.random.default_rng(0))
        tolerances = Tolerances(modal_loss_factor=0.2)
        return diagnose(model(), test, suspects=["loss_factor_error"], tolerances=tolerances)

    (limit,) = among_losses([]).detection_limits
    # That of all members is hidden by the tolerance; a single member changes the modes unequally.
    assert limit.at is not None
    assert limit.smallest > 0.2
    assert among_losses([LossFactorError(factor=1.2)]).verdict is Verdict.NOTHING_MISSING
    # Five standard deviations of every mode, logarithmic, are beyond the bounds of their tolerances.
    (found,) = among_losses([LossFactorError(factor=2.72)]).steps
    assert found.effect.kind == "loss_factor_error"


def test_effects_without_a_small_amount_have_no_limit() -> None:
    assert set(limits()) == set(KINDS) - {"cubic_stiffness"}


def test_a_diagnosis_that_leaves_a_gap_has_no_limits() -> None:
    test = measure(
        model(),
        rig(),
        [ExtraMass(at=Dof.parse("4:+Y"), mass=0.05)],
        route=Route.DRAWN,
        rng=np.random.default_rng(0),
    )
    found = diagnose(model(), test, suspects=["exciter_armature"])
    assert found.verdict is Verdict.UNEXPLAINED
    assert found.detection_limits == ()
    assert "Detection limits" not in report(found)


def test_the_report_states_limits_with_their_places() -> None:
    page = report(diagnosed([]))
    limit = limits()["extra_mass"]
    assert "Detection limits" in page
    assert f"{limit.smallest:.2g} kg ({limit.at})" in page
