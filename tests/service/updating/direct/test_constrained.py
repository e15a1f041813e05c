"""Steps under the constraint of measured modes."""

import numpy as np
import pytest

from modallab.core.errors import UnderdeterminedError
from modallab.updating.direct.constrained import constrained_stiffness, mass_orthonormal, modal_mass


def positive(n: int, rng: np.random.Generator) -> np.ndarray:
    square = rng.standard_normal((n, n))
    return np.asarray(square @ square.T + n * np.eye(n))


def case(n: int = 8, m: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(2)
    return positive(n, rng), positive(n, rng), rng.standard_normal((n, m))


def test_shapes_are_made_orthonormal_by_the_least_change() -> None:
    mass, _, shapes = case()
    found = mass_orthonormal(shapes, mass)
    np.testing.assert_allclose(found.T @ mass @ found, np.eye(3), atol=1e-13)  # rounding

    def change(candidate: np.ndarray) -> float:
        return float(np.einsum("ir,ij,jr->", candidate - shapes, mass, candidate - shapes))

    rng = np.random.default_rng(3)
    for _ in range(20):
        turn, _ = np.linalg.qr(np.eye(3) + 0.1 * rng.standard_normal((3, 3)))
        assert change(found) <= change(found @ turn * np.sign(np.diag(turn))) + 1e-12


def test_orthonormal_shapes_stay_as_they_are() -> None:
    mass, _, shapes = case()
    once = mass_orthonormal(shapes, mass)
    np.testing.assert_allclose(mass_orthonormal(once, mass), once, atol=1e-13)  # rounding


def test_the_stiffness_has_the_modes_and_is_the_nearest_that_has() -> None:
    mass, stiffness, shapes = case()
    shapes, squares = mass_orthonormal(shapes, mass), np.array([1.0, 4.0, 9.0])
    found = constrained_stiffness(stiffness, mass, shapes, squares)
    np.testing.assert_allclose(found, found.T, atol=1e-12)
    np.testing.assert_allclose(found @ shapes, mass @ shapes * squares, atol=1e-11)
    # What else has the modes differs by what acts beside the shapes only: the correction has no such part.
    beside = np.eye(len(mass)) - shapes @ shapes.T @ mass
    np.testing.assert_allclose(beside.T @ (found - stiffness) @ beside, 0.0, atol=1e-11)


def test_shapes_that_repeat_one_another_are_refused() -> None:
    mass, _, shapes = case()
    with pytest.raises(UnderdeterminedError) as caught:
        modal_mass(np.column_stack([shapes, shapes[:, 0] - 2 * shapes[:, 1]]), mass)
    assert caught.value.context["field"] == "modes"
