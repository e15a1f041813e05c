"""Tests of the correlation of lines that an extraction is given."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.fe.catalogued import STRUCTURES
from modallab.jobs.extracting import correlation_of
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.hardware import Exciter, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup


def measured(window: str, route: Route, excitation: str = "impact") -> Measurement:
    setup = RigSetup(
        (Dof(1, "Y"),),
        (Dof(5, "Y"),),
        exciter=Exciter("hammer" if excitation == "impact" else "shaker"),
        noise=Noise(1e-3, 1e-3),
        analyser=Analyser(
            100.0,
            51,
            averages=4,
            window=window,
            window_end=1e-3,
            excitation=ExcitationSetting(excitation, pre_trigger=0.1),
        ),
    )
    beam = STRUCTURES["chapter-5-beam"]()
    return replace(measure(beam, setup, route=route, rng=np.random.default_rng(0)), route=route)


def test_sampled_lines_are_correlated_by_the_declared_window_from_the_blow_on() -> None:
    correlation = correlation_of(measured("exponential", Route.SAMPLED))
    assert correlation is not None
    assert (correlation.window.end, correlation.delay, correlation.random_force) == (1e-3, 0.1, False)


def test_imported_lines_are_correlated_by_the_declared_window() -> None:
    simulated = measured("exponential", Route.SAMPLED)
    analyser = replace(simulated.setup.analyser, excitation=ExcitationSetting())  # not declared
    imported = replace(simulated, route=None, setup=replace(simulated.setup, analyser=analyser))
    correlation = correlation_of(imported)
    assert correlation is not None
    assert (correlation.window.end, correlation.delay, correlation.random_force) == (1e-3, 0.0, False)


def test_force_of_bursts_is_as_random_as_the_noise() -> None:
    correlation = correlation_of(measured("exponential", Route.SAMPLED, "burst_random"))
    assert correlation is not None
    assert correlation.random_force


@pytest.mark.parametrize(
    ("window", "route"),
    [("exponential", Route.DRAWN), ("rectangular", Route.SAMPLED), ("force", Route.SAMPLED)],
)
def test_other_lines_are_independent(window: str, route: Route) -> None:
    assert correlation_of(measured(window, route)) is None
