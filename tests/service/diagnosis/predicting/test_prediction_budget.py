"""A search that comes to an end."""

from dataclasses import replace

import pytest

import modallab.diagnosis.searching.search as module
from modallab.core.dof import Dof
from modallab.core.progress import silent
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.prediction_budget import PredictionBudget
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.predicting.settings import BudgetSettings
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.result import Verdict
from modallab.diagnosis.searching.search import search
from modallab.diagnosis.searching.search_path import kind_and_place
from modallab.diagnosis.searching.suspects import Suspects
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.ground_spring import GroundSpring
from tests.diagnosing import draw_measurement, model, rig
from tests.service.diagnosis.searching.test_search import MASS

SPRING = GroundSpring(at=MASS.at, stiffness=1e4)


def predicting() -> SingleTestPredictor:
    test = draw_measurement(rig(), [MASS], seed=3)
    return SingleTestPredictor.of(model(), test.setup, observe(test, (), fraction=0.25))


def test_every_prediction_counts_whichever_copy_makes_it() -> None:
    predictor = predicting()
    predictor.predict(())
    predictor.with_nuisances(predictor.nuisances).coarse((MASS,))
    assert predictor.budget.spent == 2


def test_a_coarse_prediction_counts_as_the_share_of_its_lines() -> None:
    log_book = rig()
    log_book = replace(log_book, analyser=replace(log_book.analyser, n_lines=641))
    test = draw_measurement(log_book, [MASS], seed=3)
    predictor = SingleTestPredictor.of(model(), test.setup, observe(test, (), fraction=0.25))
    predictor.coarse(())
    # every fourth of 641 lines, the first and the last among them
    assert predictor.budget.spent == pytest.approx(161 / 641)


@pytest.mark.parametrize(
    ("excitation", "window", "cost"), [("periodic_random", "rectangular", 1), ("random", "hann", 10)]
)
def test_a_nonlinear_force_counts_as_the_predictions_that_take_as_long(
    excitation: str, window: str, cost: int
) -> None:
    """Its motion under a continuous spectrum is that of many more frequencies than there are lines."""
    test = draw_measurement(rig(kind=excitation, window=window), [MASS], seed=3)
    predictor = SingleTestPredictor.of(model(), test.setup, observe(test, (), fraction=0.25))
    predictor.chain([CubicStiffness(MASS.at, 1e6)])
    assert predictor.budget.spent == cost


def test_a_search_that_was_given_up_follows_its_best_lead_only(monkeypatch: pytest.MonkeyPatch) -> None:
    predictor, looked = predicting(), list[int]()
    start, mass, spring = (fit(predictor, effects) for effects in ((), (MASS,), (SPRING,)))

    def trials(_predictor: Predictor, base: Fit, *_: object, **__: object) -> list[Fit]:
        looked.append(len(base.effects))
        return [] if base.effects else [mass, spring]

    monkeypatch.setattr(module, "fit_candidates", trials)
    monkeypatch.setattr(module, "is_noise_only", lambda *_: False)  # whatever is found is not enough
    predictor = replace(predictor, budget=PredictionBudget(0))
    path = search(predictor, start, Suspects([]), max_effects=4, progress=silent)
    assert looked == [0], "no second effect is looked for"
    assert [step.kind_and_place for step in path.steps] == [kind_and_place(MASS)]


def test_a_diagnosis_that_was_given_up_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("modallab.diagnosis.measured_tests.BUDGET", BudgetSettings(predictions_per_test=1))
    test = draw_measurement(rig(), [MASS], seed=3)
    found = diagnose(model(), test, suspects=["ground_spring"])
    assert found.verdict is Verdict.UNEXPLAINED
    assert any("given up" in note for note in found.notes)
    explained = diagnose(model(), test, suspects=[ExtraMass.kind])
    assert explained.verdict is Verdict.EXPLAINED
    assert not any("given up" in note for note in explained.notes), (
        "what was found leaves nothing to look for"
    )


def test_forces_that_are_stepped_through_count_as_long_as_they_take() -> None:
    test = draw_measurement(rig(kind="random", window="hann"), [MASS], seed=3)
    predictor = SingleTestPredictor.of(model(), test.setup, observe(test, (), fraction=0.25))
    hardening, other = (CubicStiffness(at=at, stiffness=1e9) for at in (MASS.at, Dof(3, "Y")))
    predictor.with_intermittent_errors((hardening,))
    once = predictor.budget.spent
    assert once > 50
    predictor.with_intermittent_errors((hardening,))
    assert predictor.budget.spent == once + 10, "what is known is not gone through again"
    predictor = replace(predictor, budget=PredictionBudget())
    predictor.with_intermittent_errors((hardening, other))
    assert predictor.budget.spent - 10 == 2 * (once - 10), "two forces are stepped through, of one prediction"
