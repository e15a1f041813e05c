import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.optimize import lsq_linear

from modallab.core.arrays import FloatArray
from modallab.diagnosis.optimisation.bounded_least_squares import bounded_least_squares


def problem(seed: int, n: int, correlated: float) -> tuple[FloatArray, FloatArray]:
    """A matrix (2 n, n) with columns that share a part, and a target."""
    rng = np.random.default_rng(seed)
    matrix = rng.standard_normal((2 * n, n)) + correlated * rng.standard_normal((2 * n, 1))
    return matrix, 5 * rng.standard_normal(2 * n)


@given(st.integers(0, 10_000), st.integers(1, 30), st.floats(0.0, 30.0), st.floats(1e-3, 10.0))
def test_no_point_within_the_bounds_is_nearer(seed: int, n: int, correlated: float, width: float) -> None:
    matrix, target = problem(seed, n, correlated)
    low, high = -width * np.ones(n), 0.5 * width * np.ones(n)
    x = bounded_least_squares(matrix, target, (low, high))
    wanted = lsq_linear(matrix, target, (low, high), method="bvls", tol=1e-14).x
    residual, other = (np.linalg.norm(matrix @ each - target) for each in (x, wanted))
    assert residual <= other * (1 + 1e-9)  # rounding; nearly dependent columns leave the solution itself open
    assert ((x >= low) & (x <= high)).all()


def test_a_solution_within_the_bounds_is_the_free_one() -> None:
    matrix, target = problem(1, 6, 1.0)
    free = np.asarray(np.linalg.lstsq(matrix, target, rcond=None)[0], float)
    assert_allclose(bounded_least_squares(matrix, target, (free - 1, free + 1)), free, rtol=1e-9)


@pytest.mark.parametrize("width", [1e-9, 1.0])
def test_columns_that_are_not_independent_have_some_solution_within_the_bounds(width: float) -> None:
    column = np.array([[1.0], [2.0], [3.0]])
    matrix, target = np.hstack([column, column, np.zeros((3, 1))]), np.array([0.9, 2.1, 3.0])
    box = -width * np.ones(3), width * np.ones(3)
    x = bounded_least_squares(matrix, target, box)
    total = min(float(column[:, 0] @ target) / 14, 2 * width)
    assert x[:2].sum() == pytest.approx(total, rel=1e-9)
