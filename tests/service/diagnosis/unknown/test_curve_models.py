"""Every model is recovered from a curve that follows it."""

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.diagnosis.unknown.curve_models import (
    FEEDBACK_MODELS,
    GAIN_MODELS,
    STIFFNESS_MODELS,
    CurveModel,
    estimate,
)

OMEGA: FloatArray = 2 * np.pi * np.linspace(5.0, 800.0, 160)
SHAPES = {
    "loss_factor": 0.07,
    "time_constant": 2e-3,
    "exponent": 0.4,
    "frequency": 130.0,
    "delay": 8e-4,
    "corner": 60.0,
}


@pytest.mark.parametrize(
    "model", [*STIFFNESS_MODELS, *FEEDBACK_MODELS, *GAIN_MODELS], ids=lambda model: model.name
)
def test_a_law_is_recovered_from_its_curve(model: CurveModel) -> None:
    shapes = np.array([SHAPES[name] for name in model.shape_units])
    curve = -3.0 * model.shape(shapes, OMEGA)
    noise = np.random.default_rng(0).standard_normal((2, len(OMEGA)))
    error = 1e-3 * np.abs(curve)
    found = estimate(model, OMEGA, curve + error * (noise[0] + 1j * noise[1]), error)
    # 320 data of 0.1 %: parameters to about 0.01 %, of a frequency or delay less; 1 % is a hundred of them
    assert found.values == pytest.approx([-3.0, *shapes], rel=0.01)
    assert found.chi_square < 320 + 5 * np.sqrt(2 * 320)  # five standard deviations of chi-square
