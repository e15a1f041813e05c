"""Derivatives by nuisance parameters: as precise as least squares need."""

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.diagnosis.optimisation.nuisance_parameters import nuisance_parameters
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.residuals.residual import residual
from tests.diagnosing import draw_measurement, predicting, rig


@pytest.mark.parametrize(
    "tolerances",
    [
        Tolerances(modulus_variation=3e-4),
        Tolerances(density_variation=0.03),
        Tolerances(modulus=0.003, density=1e-4, accelerometer_mass=0.03),
        Tolerances(modal_loss_factor=0.2),
        Tolerances(sensitivity=0.005, delay=1e-6),
    ],
    ids=["modulus by member", "density by member", "factors", "losses", "channels"],
)
def test_derivatives_by_small_deviations_are_not_rounding(tolerances: Tolerances) -> None:
    setup = rig(noise=1e-5)
    predictor, _ = predicting(draw_measurement(setup))
    predictor = predictor.with_nuisances(nuisance_parameters(tolerances, predictor.system, setup))
    prediction, nuisances = predictor.coarse_prediction(()), predictor.nuisances
    observed = prediction.observed

    def vector(position: FloatArray) -> FloatArray:
        predicted = prediction.predict([*nuisances.effects(position)])
        return residual(observed, predicted).vector(observed.fitted)

    step = 0.02  # of a standard deviation: curvature cancels in the central difference
    expected = np.array(
        [(vector(step * unit) - vector(-step * unit)) / (2 * step) for unit in np.eye(len(nuisances))]
    )
    error = np.linalg.norm(prediction.derivatives - expected.T, axis=0)
    visible = np.linalg.norm(expected, axis=1) > 1  # a smaller change is not told from random error
    assert visible.any()
    # Columns that nearly cancel leave a hundredth of their length: an error of a third of that is small.
    assert (error / np.linalg.norm(expected, axis=1))[visible].max() < 3e-3
