"""A test of which lines are missing is predicted at the lines that there are."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.predicting.comparability import check_comparable
from modallab.effects.extra_mass import ExtraMass
from modallab.rig.measurement import Measurement
from tests.diagnosing import draw_measurement, model, predicting, rig

HIDDEN = ExtraMass(at=Dof(4, "Y"), mass=0.03)
# 60 to 250 Hz, and of the rest a stretch higher up
KEPT = np.r_[24:101, 120:141]


def at(measurement: Measurement, lines: np.ndarray) -> Measurement:
    return measurement.by_line(lambda array: array[lines])


@pytest.mark.parametrize(
    ("kind", "window"), [("periodic_random", "hann"), ("random", "hann"), ("pseudo_random", "rectangular")]
)
def test_lines_that_are_left_are_predicted_as_ever(kind: str, window: str) -> None:
    # made here: of an imported test noise of the force is fitted to the lines that there are
    whole = replace(draw_measurement(rig(kind=kind, window=window), [HIDDEN]), route="drawn")
    everywhere, _ = predicting(whole)
    predictor, _ = predicting(at(whole, KEPT))
    for some, every in (
        (predictor.predict([HIDDEN]), everywhere.predict([HIDDEN])),
        (predictor.linearisation_at(())([HIDDEN]), everywhere.linearisation_at(())([HIDDEN])),
    ):
        for name in ("h", "coherence", "force", "incoherent"):
            # the same sums in another order: rounding
            np.testing.assert_allclose(getattr(some, name), getattr(every, name)[KEPT], rtol=1e-9)
    coarse = predictor.coarse([HIDDEN])
    places = predictor.coarse_places
    assert coarse.h.shape == (len(places), 6)
    exact = predictor.predict([HIDDEN])
    # a coarse grid of leakage is off by some per cent where resonances are narrower than a line
    assert np.median(np.abs(coarse.h / exact.h[places] - 1)) < 0.05


def test_a_cut_file_on_the_rig_of_the_whole_test_is_explained() -> None:
    found = diagnose(
        model(), at(draw_measurement(rig(), [HIDDEN]), KEPT), suspects=["extra_mass", "stiffness_error"]
    )
    assert [(step.effect.kind, step.effect.at) for step in found.steps] == [("extra_mass", HIDDEN.at)]
    assert found.steps[0].effect.parameters["mass"].value == pytest.approx(0.03, rel=0.1)
    assert found.curves.freq.tolist() == (KEPT * 2.5).tolist()


def test_an_analyser_that_starts_above_rest_is_explained() -> None:
    setup = rig()
    cut = replace(setup, analyser=replace(setup.analyser, frequency_min=60.0, n_lines=137))
    measurement = at(draw_measurement(setup, [HIDDEN]), np.arange(24, 161))
    found = diagnose(model(), replace(measurement, setup=cut), suspects=["extra_mass", "stiffness_error"])
    assert [(step.effect.kind, step.effect.at) for step in found.steps] == [("extra_mass", HIDDEN.at)]


def test_lines_that_no_record_has_are_refused_by_name() -> None:
    setup, lines = rig(), np.arange(24, 161)
    shifted = replace(
        setup, analyser=replace(setup.analyser, frequency_min=61.0, frequency_max=401.0, n_lines=137)
    )
    measurement = at(draw_measurement(setup), lines)
    moved = replace(measurement, frf=replace(measurement.frf, freq=measurement.frf.freq + 1), setup=shifted)
    with pytest.raises(InvalidInputError) as refused:
        check_comparable(model(), moved)
    assert refused.value.context["field"] == "frequency_min"
