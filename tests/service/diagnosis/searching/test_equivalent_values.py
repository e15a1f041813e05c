"""Numbers of an effect that a test hardly tells apart: hum on either side of its line."""

from dataclasses import replace

import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.searching.equivalent_values import resolve_equivalents
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.mains_hum import MainsHum
from tests.diagnosing import draw_measurement, predicting, rig

CHANNEL = Channels((Dof(5, "Y"),))
LINE = 50.0  # Hz; lines are 2.5 Hz apart


def hum(offset: float) -> MainsHum:
    return MainsHum(CHANNEL, ratio=0.3, frequency=LINE + offset)


def fitted(true: MainsHum, started: MainsHum) -> tuple[Fit, Fit]:
    """Return the fit from a start, and what becomes of it."""
    predictor, _ = predicting(draw_measurement(rig(noise=1e-3), [true], seed=1))
    found = fit(predictor, (started,))
    return found, resolve_equivalents(predictor, found)


@pytest.mark.parametrize("started", [-0.02, 0.02])
def test_a_frequency_that_may_lie_on_either_side_of_its_line_has_an_error_that_spans_both(
    started: float,
) -> None:
    alone, best = fitted(hum(0.02), hum(started))
    value, error = best.effects[0].parameters["frequency"], best.errors[0]["frequency"]
    assert abs(value - LINE - 0.02) < 1.96 * error
    assert 10 * alone.errors[0]["frequency"] < error < 0.04, "as far as the other side, and no farther"
    ratio = alone.errors[0]["ratio"]
    # how loud it is does not depend on the side: the difference is of the far lines' leakage alone
    assert best.errors[0]["ratio"] == pytest.approx(ratio, rel=0.02)


def test_a_side_that_the_neighbouring_lines_tell_is_taken() -> None:
    true = hum(0.6)  # a quarter of a line off
    _, best = fitted(true, hum(-0.6))
    value, error = best.effects[0].parameters["frequency"], best.errors[0]["frequency"]
    assert abs(value - true.frequency) < 3 * error
    assert error < 0.05, "the other side, 1.2 Hz off, is ruled out"


def test_a_value_without_equivalents_is_left_as_it_is() -> None:
    predictor, _ = predicting(draw_measurement(rig(), [ExtraMass(Dof(4, "Y"), 0.02)]))
    found = fit(predictor, (ExtraMass(Dof(4, "Y"), 0.02),))
    assert resolve_equivalents(predictor, found) is found


def test_hum_below_the_lowest_mains_has_no_equivalent() -> None:
    coarse = replace(rig(), analyser=replace(rig().analyser, n_lines=9))  # 50 Hz apart
    assert MainsHum(frequency=85.0).equivalent(coarse) == MainsHum(frequency=115.0)
    assert MainsHum(frequency=24.0).equivalent(coarse) is None  # -24 Hz
