"""Deviations of many parameters that one effect explains better."""

import numpy as np
import pytest

from modallab.core.progress import silent
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.optimisation.nuisance_parameters import nuisance_parameters
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.reporting.verdict_text import verdict_text
from modallab.diagnosis.result import Verdict
from modallab.diagnosis.searching.gap_tests import is_noise_only
from modallab.diagnosis.searching.search import search
from modallab.diagnosis.searching.suspects import Suspects
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.gain_error import GainError
from modallab.effects.loss_factor_error import LossFactorError
from modallab.rig.effect import Effect
from tests.diagnosing import draw_measurement, model, predicting, rig

TOLERANCES = Tolerances(modal_loss_factor=0.2, sensitivity=0.02)
SUSPECTS = Suspects([LossFactorError(), GainError(), ExtraMass()])


def found_effects(
    *hidden: Effect, position: float | None = None, suspects: Suspects = SUSPECTS
) -> list[Effect]:
    """Return what a search names under the tolerances, where these alone leave no gap."""
    setup = rig(roving=False)
    predictor, _ = predicting(draw_measurement(setup))
    numbers = nuisance_parameters(TOLERANCES, predictor.system, setup)
    deviating: tuple[Effect, ...] = ()
    if position is not None:
        up_and_down = np.where(np.arange(len(numbers)) % 2, 1.0, -1.0)
        deviating = numbers.effects(position * up_and_down)
    predictor, _ = predicting(draw_measurement(setup, [*hidden, *deviating]))
    predictor = predictor.with_nuisances(numbers)
    start = fit(predictor, ())
    assert is_noise_only(predictor, start)
    return list(search(predictor, start, suspects, max_effects=2, progress=silent).fit.effects)


@pytest.mark.parametrize(
    ("hidden", "amount"), [(LossFactorError(factor=0.6), 0.6), (GainError(factor=1.05), 1.05)]
)
def test_a_deviation_of_all_is_one_effect(hidden: Effect, amount: float) -> None:
    (effect,) = found_effects(hidden)
    assert (effect.kind, effect.at) == (hidden.kind, None)
    # Of ten modes, or six channels, with their tolerances about it: 20 % and 2 % over the root of these.
    assert effect.parameters["factor"] == pytest.approx(amount, rel=0.2 if amount < 1 else 0.03)


def test_deviations_in_both_directions_are_none() -> None:
    assert not found_effects(position=2.0)


def test_what_is_not_suspected_is_not_named() -> None:
    assert not found_effects(LossFactorError(factor=0.6), suspects=Suspects([ExtraMass()]))


def test_a_diagnosis_says_that_tolerances_would_do_but_are_improbable() -> None:
    test = draw_measurement(rig(), [LossFactorError(factor=0.6)])
    found = diagnose(model(), test, tolerances=Tolerances(modal_loss_factor=0.2))
    assert found.verdict is Verdict.EXPLAINED
    (step,) = found.steps
    assert step.effect.kind == "loss_factor_error"
    assert "in the same direction" in verdict_text(found)
