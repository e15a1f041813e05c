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
    two_poles,
)

OMEGA: FloatArray = 2 * np.pi * np.linspace(5.0, 800.0, 160)
SHAPES = {
    "loss_factor": 0.07,
    "time_constant": 2e-3,
    "exponent": 0.4,
    "frequency": 130.0,
    "second_frequency": 410.0,
    "second_loss_factor": 0.02,
    "mass_ratio": 0.4,
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
    assert found is not None
    assert found.values == pytest.approx([-3.0, *shapes], rel=0.01)
    assert found.chi_square < 320 + 5 * np.sqrt(2 * 320)  # five standard deviations of chi-square


def test_poles_of_a_rational_function_are_exact() -> None:
    x = OMEGA**2
    poles, residues = np.array([6e5 * (1 + 0.02j), 6e6 * (1 + 0.1j)]), np.array([2e5 + 1e4j, 3e6 - 2e5j])
    found, amounts = two_poles(x, (residues / (poles - x[:, None])).sum(axis=1), np.ones(len(x)))
    order = np.argsort(found.real)
    # rounding of a linear fit whose columns span four decades
    np.testing.assert_allclose(found[order], poles, rtol=1e-8)
    np.testing.assert_allclose(amounts[order], residues, rtol=1e-7)


def test_a_curve_of_two_masses_of_opposite_sign_starts_none() -> None:
    (model,) = (m for m in STIFFNESS_MODELS if m.name == "two_oscillators")
    # masses of opposite sign
    own = np.array([6e5, 6e6]) * (1 + 0.05j)
    curve = -(OMEGA**2) * ([1.0, -2.0] * own / (own - OMEGA[:, None] ** 2)).sum(axis=1)
    assert estimate(model, OMEGA, np.asarray(curve), np.ones(len(OMEGA))) is None
