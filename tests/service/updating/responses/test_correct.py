"""The path to a model's coefficients: where it begins, and where it does not lead."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.fe.assembly import Assembly
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.updating.corrected_model import CorrectedModel
from modallab.updating.iteration import StopReason
from modallab.updating.one_stage_path import OneStageRule
from modallab.updating.responses import correct as module
from modallab.updating.responses.correct import ResponsePath, correct
from modallab.updating.responses.fields import ResponseModel
from modallab.updating.responses.settings import RESPONSE_PATH
from modallab.updating.sparse_bayes import Prior
from tests.service.updating.responses.cases import (
    BAY,
    BAY_EACH,
    BAY_LINES,
    BAY_SENSORS,
    BEAM,
    BEAM_EACH,
    BEAM_LINES,
    BEAM_SENSORS,
    exact,
    measured,
)

# Resonances fall by up to 13 %: many times their width of half a per cent.
SOFT = change(BEAM, [MemberChange((8, 9, 10), MemberProperty.MODULUS, factor=0.5)])
TRUTH = np.concatenate([np.ones(20), np.where(np.isin(np.arange(1, 21), (8, 9, 10)), 0.5, 1.0)])


def path(rule: OneStageRule, upper: float = 10.0, lower: float = 0.05) -> tuple[ResponsePath, list[float]]:
    target = exact(measured(SOFT, BEAM_LINES[::4], BEAM_SENSORS))
    parameters = type(BEAM_EACH)(BEAM_EACH.macros, lower, upper)
    model = CorrectedModel(Assembly(BEAM), parameters)
    few = target.at(target.evenly_spaced(RESPONSE_PATH.coarse_numbers))
    told: list[float] = []
    found = correct(
        ResponseModel(model, target),
        ResponseModel(model, few),
        rule,
        lambda fraction, _: told.append(fraction),
    )
    return found, told


def off(values: FloatArray) -> float:
    return float(np.abs(values - TRUTH).max())


RULE = OneStageRule(Prior.SPARSE, 1e-4, 30, 1e3)


def test_the_path_ends_at_the_truth_and_tells_of_its_progress() -> None:
    found, told = path(RULE)
    assert found.stop_reason is StopReason.CONVERGED
    assert off(found.values) < 1e-6
    assert found.final_mean_square < 1 < found.initial_mean_square
    assert told == sorted(told)
    assert len(told) == len(found.history)


def test_log_ratios_from_the_start_lose_their_way(monkeypatch: pytest.MonkeyPatch) -> None:
    """Why the path begins with a model that is taken to be wrong: of the bay the first 10 modes cross."""
    wrong = [MemberChange((7,), MemberProperty.DENSITY, factor=2.6)]
    wrong += [MemberChange((7, 12), MemberProperty.MODULUS, factor=0.4)]
    target = exact(measured(change(BAY, wrong), BAY_LINES[::2], BAY_SENSORS))
    model = ResponseModel(CorrectedModel(Assembly(BAY), BAY_EACH), target)
    rule = OneStageRule(Prior.SPARSE, 1e-4, 12, 1e3)
    led = correct(model, model, rule)
    single_path = replace(RESPONSE_PATH, error_factors=(1.0,), max_steps=(0,))
    monkeypatch.setattr(module, "RESPONSE_PATH", single_path)
    lost = correct(model, model, rule)
    assert led.stop_reason is StopReason.CONVERGED
    assert led.final_mean_square < 1
    assert lost.final_mean_square > 1e3


def test_no_coefficient_more_than_halves_in_a_step() -> None:
    found, _ = path(RULE)
    values = np.array([np.ones(40), *(one.coefficients for one in found.history)])
    assert (values[1:] / values[:-1]).max() < 2 + 1e-9
    assert (values[1:] / values[:-1]).min() > 0.5 - 1e-9


def test_coefficients_stay_within_their_bounds_and_say_so() -> None:
    found, _ = path(OneStageRule(Prior.SPARSE, 1e-4, 5, 1e3), lower=0.7)
    assert found.values.min() >= 0.7 - 1e-12
    assert "rest on a bound" in found.explanation


def test_a_path_that_is_cut_short_says_so() -> None:
    found, _ = path(OneStageRule(Prior.SPARSE, 1e-12, 1, 1e3))
    assert found.stop_reason is StopReason.STILL_MOVING


def test_progress_goes_on_where_a_second_path_begins() -> None:
    found, told = path(OneStageRule(Prior.SPARSE, 1e-12, 1, 1e3), lower=0.7)  # the truth is beyond the bound
    assert found.final_mean_square > RESPONSE_PATH.explained_mean_square
    assert len(told) > len(found.history), "both paths tell of theirs"
    assert told == sorted(told)
