"""When what is left of a gap is noise, and when no further effect could be fitted to it."""

import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.frf_selection import FrfSelection
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.searching.gap_tests import has_no_lack_of_fit, is_noise_only
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.gain_error import GainError
from tests.diagnosing import draw_measurement, model, rig

HELD_OUT = Dof(5, "Y")


@pytest.mark.parametrize(("error", "finished"), [(1.002, True), (1.01, False)])
def test_a_small_error_of_held_out_channels_alone_asks_for_no_further_effect(
    error: float, finished: bool
) -> None:
    mass, gain = ExtraMass(Dof(6, "Y"), 0.05), GainError(Channels((HELD_OUT,)), error)
    test = draw_measurement(rig(), [mass, gain])
    observed = observe(test, [FrfSelection(HELD_OUT)], fraction=0.0)
    predictor = SingleTestPredictor.of(model(), test.setup, observed)
    before, found = fit(predictor, ()), fit(predictor, [mass])
    assert not is_noise_only(predictor, found)  # 0.2 % is twice the random error
    assert has_no_lack_of_fit(predictor, before, found) == finished
    assert not has_no_lack_of_fit(predictor, before, before)
