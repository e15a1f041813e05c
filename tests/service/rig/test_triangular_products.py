"""Tests of products with stacks of triangular matrices."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.rig.triangular_products import (
    add_adjoint_product,
    product_of_triangles,
    triangular_product,
    triangular_square,
)


def stack(rng: np.random.Generator, *shape: int) -> ComplexArray:
    return np.asarray(rng.standard_normal(shape) + 1j * rng.standard_normal(shape))


def triangles(rng: np.random.Generator, *shape: int) -> ComplexArray:
    lower = np.tril(stack(rng, *shape))
    diagonal = np.arange(shape[-1])
    lower[..., diagonal, diagonal] = lower[..., diagonal, diagonal].real
    return np.asarray(lower)


@pytest.mark.parametrize("n", [1, 2, 4])
def test_products_are_those_of_full_matrices(n: int) -> None:
    rng = np.random.default_rng(n)
    first, second, right = triangles(rng, 7, n, n), triangles(rng, 3, 7, n, n), stack(rng, 3, 7, n, 5)
    adjoint, added = second.conj().swapaxes(-1, -2), stack(rng, 3, 7, n, 5)
    for product, expected in (
        (triangular_product(second, right, np.empty_like(right)), second @ right),
        (add_adjoint_product(second, right, added.copy()), added + adjoint @ right),
        (triangular_square(second, np.empty_like(second)), second @ adjoint),
        (product_of_triangles(first, second), first @ second),
    ):
        np.testing.assert_allclose(product, expected, rtol=0, atol=1e-14)  # rounding of sums of order 1
