"""Quadratic forms between bounds, against bounded least squares of scipy."""

import numpy as np
from scipy.optimize import lsq_linear

from modallab.diagnosis.optimisation.bounded_quadratic import BoundedQuadratic


def test_many_steps_in_a_box_are_nearly_the_best_ones() -> None:
    rng = np.random.default_rng(1)
    slopes, vectors = rng.normal(size=(60, 5)), 3.0 * rng.normal(size=(20, 60))
    slopes[:, 1] += slopes[:, 0]  # two that look alike
    low, high = -rng.random(5), rng.random(5)
    steps = BoundedQuadratic(slopes.T @ slopes).minimise(vectors @ slopes, low, high)
    assert (steps >= low).all()
    assert (steps <= high).all()
    for vector, step in zip(vectors, steps, strict=True):
        best = lsq_linear(slopes, -vector, (low, high), method="bvls")
        gained, most = (
            vector @ vector - np.sum((vector + slopes @ step) ** 2),
            vector @ vector - 2 * best.cost,
        )
        assert gained > 0.97 * most  # six sweeps of alternating steps leave a few per cent


def test_one_step_that_no_bound_cuts_is_newtons() -> None:
    curvature, pull = np.array([[2.0, 1.0], [1.0, 3.0]]), np.array([0.4, -0.2])
    step = BoundedQuadratic(curvature).minimise(pull, np.full(2, -1.0), np.full(2, 1.0))
    np.testing.assert_allclose(curvature @ step, -pull, atol=1e-12)
