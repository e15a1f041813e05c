"""Tests of a window in the log book that is not the one in use."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.predicting.window_in_use import with_window_in_use
from modallab.diagnosis.result import Verdict
from modallab.rig.analyser import ExcitationSetting
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from tests.diagnosing import model, rig


def uploaded(kind: str, window: str, declared_kind: str, declared_window: str) -> Measurement:
    """Return sampled records of one kind and window, with a log book that declares others."""
    setup = rig(kind=kind, window=window, averages=40, noise=1e-3)
    setup = replace(setup, analyser=replace(setup.analyser, n_lines=401))
    test = measure(model(), setup, route=Route.SAMPLED, rng=np.random.default_rng(3))
    declared = replace(setup.analyser, window=declared_window, excitation=ExcitationSetting(declared_kind))
    return replace(test, route=None, setup=replace(setup, analyser=declared))


def test_random_records_declared_periodic_are_leakage_through_their_own_window() -> None:
    test = uploaded("random", "hann", "periodic_random", "rectangular")
    found = diagnose(model(), test, suspects=("leakage", "local_damping", "force_noise"))
    assert found.verdict is Verdict.EXPLAINED
    assert [step.effect.kind for step in found.steps] == ["leakage"]
    share = found.steps[0].effect.parameters["share"]
    assert share.value > 0.9  # all of it; the fit is held below 1
    assert found.setup.analyser.window == "hann"
    assert any("correlated as by hann" in note for note in found.notes)


@pytest.mark.parametrize(("kind", "window"), [("periodic_random", "rectangular"), ("random", "hann")])
def test_a_true_log_book_stays(kind: str, window: str) -> None:
    test = uploaded(kind, window, kind, window)
    assert with_window_in_use(test) == (test, ())


def test_a_window_that_the_records_had_not_is_taken_off() -> None:
    corrected, notes = with_window_in_use(
        uploaded("periodic_random", "rectangular", "periodic_random", "hann")
    )
    assert corrected.setup.analyser.window == "rectangular"
    assert len(notes) == 1


def test_random_excitation_is_not_given_a_rectangular_window() -> None:
    test = uploaded("periodic_random", "rectangular", "random", "hann")
    same, (note,) = with_window_in_use(test)
    assert same is test
    assert "repeats with the record" in note


def test_a_test_of_this_service_keeps_its_log_book() -> None:
    test = replace(uploaded("random", "hann", "periodic_random", "rectangular"), route=Route.SAMPLED)
    assert with_window_in_use(test) == (test, ())
