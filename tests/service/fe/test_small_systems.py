"""Small linear systems."""

import numpy as np
import pytest

from modallab.fe.small_systems import solve_small


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_small_systems_are_solved_as_by_the_solver(n: int) -> None:
    rng = np.random.default_rng(n)
    matrix = rng.standard_normal((2, 5, n, n)) + 1j * rng.standard_normal((2, 5, n, n))
    matrix += 2 * n * np.eye(n)  # well-conditioned, as a structure with what is attached to it
    loads = rng.standard_normal((2, 5, n, 3)) + 1j * rng.standard_normal((2, 5, n, 3))
    expected = np.linalg.solve(matrix, loads)
    assert solve_small(matrix, loads) == pytest.approx(expected, rel=1e-12, abs=1e-14)  # rounding
