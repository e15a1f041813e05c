"""Tests of the averages that are estimated where neither averages nor window are declared."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.interchange.declared import DeclaredTest
from modallab.interchange.measured import MeasuredFile
from modallab.rig.analyser import ExcitationSetting
from modallab.rig.hardware import Noise
from modallab.rig.measure import Route, measure
from tests.diagnosing import model, rig

AVERAGES = 5


def windowed_file() -> MeasuredFile:
    setup = rig(kind="impact", window="exponential", averages=AVERAGES)
    analyser = replace(setup.analyser, n_lines=801, excitation=ExcitationSetting("impact"))
    test = measure(
        model(),
        replace(setup, analyser=analyser, noise=Noise(1e-3, 1e-3)),
        route=Route.SAMPLED,
        rng=np.random.default_rng(7),
    )
    coherence = test.coherence
    assert coherence is not None
    return MeasuredFile(test.frf, coherence=coherence)


@pytest.mark.parametrize("window", [None, "exponential"])
def test_averages_of_a_windowed_hammer_test_are_estimated(window: str | None) -> None:
    measurement = windowed_file().without_log_book(DeclaredTest(window=window))
    # the noise, over sqrt(averages - 1), within 20 %
    assert np.sqrt((measurement.averages - 1) / (AVERAGES - 1)) == pytest.approx(1, abs=0.2)


def test_an_undeclared_exponential_window_is_named_among_the_assumptions() -> None:
    measurement = windowed_file().without_log_book()
    reason = next(each.reason for each in measurement.assumed if each.quantity == "window")
    assert "exponential window that falls to 0.01" in reason


def test_declared_averages_are_kept() -> None:
    measurement = windowed_file().without_log_book(DeclaredTest(averages=8))
    assert measurement.averages == 8
