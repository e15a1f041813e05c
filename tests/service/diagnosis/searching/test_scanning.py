import pytest

from modallab.core.progress import silent
from modallab.diagnosis.fitting.coarse_fit import coarse_fit
from modallab.diagnosis.searching.scanning import scan
from modallab.effects.exciter_armature import ExciterArmature
from tests.diagnosing import draw_measurement, predicting, rig


@pytest.mark.parametrize("mass", [0.09, 0.45, 1.2])
def test_an_armature_is_found_whose_force_peaks_have_many_valleys(mass: float) -> None:
    predictor, _ = predicting(draw_measurement(rig(), [ExciterArmature(mass=mass)]))
    glimpses = predictor.coarse_prediction(())
    starts = scan(glimpses, (), [ExciterArmature()], silent)
    near = [coarse_fit(glimpses, (), start.effect, start.noise_inflation) for start in starts]
    best, _ = min(near, key=lambda pair: pair[1])
    # The next valley is a tenth away or more; within one only the scatter of the force spectrum is left.
    assert best.parameters["mass"] == pytest.approx(mass, rel=0.02)
