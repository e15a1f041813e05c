"""Which effects are followed up, and which are accepted."""

from dataclasses import replace

import numpy as np
import pytest

import modallab.diagnosis.searching.search as module
from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.core.progress import silent
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.frf_selection import FrfSelection
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.searching.search import search, significant_fits
from modallab.diagnosis.searching.search_path import kind_and_place
from modallab.diagnosis.searching.suspects import Suspects
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.polarity import Polarity
from modallab.effects.response_noise import ResponseNoise
from modallab.rig.measure import Route, measure
from tests.diagnosing import draw_measurement, model, predicting, rig

MASS, TURNED = ExtraMass(Dof(4, "Y"), 0.02), Polarity(Channels((Dof(5, "Y"),)))


@pytest.fixture(scope="module")
def predictor() -> Predictor:
    test = draw_measurement(rig(), [MASS], seed=3)
    return SingleTestPredictor.of(
        model(), test.setup, observe(test, [FrfSelection(Dof(7, "Y"))], fraction=0.25)
    )


@pytest.fixture(scope="module")
def found(predictor: Predictor) -> list[Fit]:
    """What is not there comes first, as leakage does that soaks up what nothing else is let explain."""
    return [fit(predictor, (one,)) for one in (TURNED, MASS)]


def test_what_is_not_convincing_hides_nothing_behind_it(predictor: Predictor, found: list[Fit]) -> None:
    ((best, left),) = significant_fits(predictor, fit(predictor, ()), found)
    assert best is found[1]
    assert left == (found[1],), "what was turned down is no rival"


def test_a_search_goes_on_past_what_is_not_convincing(
    predictor: Predictor, found: list[Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "fit_candidates", lambda *_, **__: found)
    path = search(predictor, fit(predictor, ()), Suspects([]), max_effects=1, progress=silent)
    assert [step.kind_and_place for step in path.steps] == [kind_and_place(MASS)]


def test_where_nothing_can_be_added_is_not_looked_again(
    predictor: Predictor, found: list[Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    looked: list[int] = []

    def trials(_predictor: Predictor, base: Fit, *_: object, **__: object) -> list[Fit]:
        looked.append(len(base.effects))
        return [] if base.effects else found

    monkeypatch.setattr(module, "fit_candidates", trials)
    monkeypatch.setattr(module, "is_noise_only", lambda *_: False)  # so that it is looked for a second one
    monkeypatch.setattr(module, "has_no_lack_of_fit", lambda *_: False)
    path = search(predictor, fit(predictor, ()), Suspects([]), max_effects=4, progress=silent)
    assert len(path.steps) == 1
    assert looked == [0, 1]


def test_a_search_ends_at_a_pair_that_later_tolerances_explain(
    predictor: Predictor, found: list[Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []

    def trials(_predictor: Predictor, base: Fit, *_: object, **__: object) -> list[Fit]:
        asked.append(len(base.effects))
        more = ExtraMass(Dof(2 + len(base.effects), "Y"), 1e-3)
        return [fit(predictor, (*base.effects, more))] if base.effects else [found[1]]

    monkeypatch.setattr(module, "fit_candidates", trials)
    monkeypatch.setattr(module, "is_noise_only", lambda *_: False)
    monkeypatch.setattr(module, "has_no_lack_of_fit", lambda *_: False)
    monkeypatch.setattr(module, "is_significant", lambda *_: True)
    monkeypatch.setattr(module, "excess_ratio", lambda *_: 0.0)
    monkeypatch.setattr(module, "refine_path", lambda _, path: path)  # which would take the second out again
    start = fit(predictor, ())
    path = search(predictor, start, Suspects([]), max_effects=4, progress=silent, explains=lambda _: True)
    assert len(path.steps) == 2
    assert asked == [0, 1]


@pytest.mark.parametrize(("left", "followed"), [(0.5, 2), (0.9, 1)])
def test_where_the_best_first_effect_closes_little_no_other_is_followed(
    predictor: Predictor, found: list[Fit], monkeypatch: pytest.MonkeyPatch, left: float, followed: int
) -> None:
    asked: list[int] = []

    def trials(_predictor: Predictor, base: Fit, *_: object, **__: object) -> list[Fit]:
        asked.append(len(base.effects))
        return [] if base.effects else found

    monkeypatch.setattr(module, "fit_candidates", trials)
    monkeypatch.setattr(module, "is_noise_only", lambda *_: False)
    monkeypatch.setattr(module, "has_no_lack_of_fit", lambda *_: False)
    monkeypatch.setattr(module, "is_significant", lambda *_: True)
    monkeypatch.setattr(module, "excess_ratio", lambda *_: left)
    # fits of one cost, so that neither is left out for its own
    first = [replace(one, chi_square=found[0].chi_square) for one in found]
    search(predictor, fit(predictor, ()), Suspects([]), max_effects=4, progress=silent, first_round=first)
    assert asked == [1] * followed


def test_noise_beside_something_larger_is_no_leakage() -> None:
    # Noise beyond the error of its declared level goes together over all lines, as leakage does.
    hidden = (MASS, ResponseNoise(ratio=6e-3))
    test = draw_measurement(rig(kind="random", window="hann", noise=1e-2), hidden, seed=5)
    predictor = SingleTestPredictor.of(
        model(), test.setup, observe(test, [FrfSelection(Dof(7, "Y"))], fraction=0.25)
    )
    suspects = Suspects([ExtraMass(MASS.at), ResponseNoise()])
    path = search(predictor, fit(predictor, ()), suspects, max_effects=3, progress=silent)
    assert {step.kind_and_place for step in path.steps} == {kind_and_place(one) for one in hidden}


@pytest.mark.parametrize(("hidden", "looked_at"), [(1e10, [0, 1]), (1e11, [0])])
def test_beside_a_strong_nonlinear_force_no_effect_is_sought_in_the_errors_of_predictions(
    hidden: float, looked_at: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of tests stepped through time: predictions know the mean of a strong one to some per cent only."""
    force, noise = CubicStiffness(Dof(5, "Y"), hidden), rig(noise=1e-5)
    rng = np.random.default_rng(1)
    predictor, _ = predicting(measure(model(), noise, [force], route=Route.SAMPLED, rng=rng))
    start = fit(predictor, ())
    found = fit(predictor, (force,))
    looked: list[int] = []

    def trials(_predictor: Predictor, base: Fit, *_: object, **__: object) -> list[Fit]:
        looked.append(len(base.effects))
        return [] if base.effects else [found]

    monkeypatch.setattr(module, "fit_candidates", trials)
    # It is not acceptance that is tried here.
    monkeypatch.setattr(module, "is_noise_only", lambda *_: False)
    monkeypatch.setattr(module, "has_no_lack_of_fit", lambda *_: False)
    monkeypatch.setattr(module, "is_significant", lambda *_: True)
    path = search(predictor, start, Suspects([]), max_effects=3, progress=silent)
    assert [step.kind_and_place for step in path.steps] == [kind_and_place(force)]
    assert looked == looked_at
