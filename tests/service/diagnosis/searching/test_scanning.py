from dataclasses import replace

import pytest

from modallab.core.place import Members
from modallab.core.progress import silent
from modallab.diagnosis.fitting.coarse_fit import coarse_fit
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.searching.scanning import scan
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.stiffness_error import StiffnessError
from modallab.fe.assembly import assemble
from modallab.fe.damping import StructuralDamping
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.measure import measurement_of
from tests.diagnosing import draw_measurement, model, predicting, rig


@pytest.mark.parametrize("mass", [0.09, 0.45, 1.2])
def test_an_armature_is_found_whose_force_peaks_have_many_valleys(mass: float) -> None:
    predictor, _ = predicting(draw_measurement(rig(), [ExciterArmature(mass=mass)]))
    coarse = predictor.coarse_prediction(())
    starts = scan(coarse, (), [ExciterArmature()], silent)
    near = [coarse_fit(coarse, (), start.effect, start.noise_inflation) for start in starts]
    best, _ = min(near, key=lambda pair: pair[1])
    # The next valley is a tenth away or more; within one only the scatter of the force spectrum is left.
    assert best.parameters["mass"] == pytest.approx(mass, rel=0.02)


@pytest.mark.parametrize("factor", [0.72, 0.78, 1.25, 1.37])
def test_a_wrong_member_starts_from_the_amount_of_least_loss(factor: float) -> None:
    """Between grid values, from which least squares end in false minima where damping is light."""
    place = Members((4,))
    structure = replace(model(), damping=StructuralDamping(stiffness_coefficient=2e-3))
    real = StiffnessError(at=place, factor=factor).added_to(structure)
    test = measurement_of(expected_spectra(chain(assemble(real), rig(), ())), rig())
    observed = observe(test, (), fraction=0.0)
    predictor = SingleTestPredictor.of(structure, test.setup, observed)
    starts = scan(predictor.coarse_prediction(()), (), [StiffnessError(at=place)], silent)
    # to a fiftieth of the range between the grid values beside it, of amounts up to twice as large
    assert min(abs(start.effect.parameters["factor"] - factor) for start in starts) < 0.02
