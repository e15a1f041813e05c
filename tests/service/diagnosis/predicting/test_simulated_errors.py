"""Random errors from simulated tests."""

import numpy as np

from modallab.core.dof import Dof
from modallab.diagnosis.predicting.simulated_errors import simulated_factors
from modallab.effects.friction import Friction
from modallab.rig.expected import expected_spectra
from modallab.rig.periodic_variance import VarianceFactors
from tests.diagnosing import draw_measurement, predicting, rig


def test_friction_that_sticks_far_below_the_motion_is_simulated_once() -> None:
    """Each of these was stepped through by itself, five times as slowly as one that sticks sooner."""
    setup = rig(kind="random", window="hann", averages=10, roving=False)
    predictor, _ = predicting(draw_measurement(setup))

    def factors(sticking: float) -> VarianceFactors:
        effects = (Friction(Dof(4, "Y"), 0.02, sticking),)
        whole = predictor.chain(effects)
        found = simulated_factors(predictor, whole, expected_spectra(whole), effects, 2)
        assert found is not None
        return found

    first = factors(1e-8)
    assert predictor.simulated.n_simulated == 2
    assert factors(1e-7) is first
    assert predictor.simulated.n_simulated == 2
    other = factors(1e-2)  # it hardly lets go: a damper, without bursts
    assert predictor.simulated.n_simulated == 4
    assert np.mean(other.response) < np.mean(first.response)
