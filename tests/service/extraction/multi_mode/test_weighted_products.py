import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.multi_mode.line_groups import proportional_groups
from modallab.extraction.multi_mode.weighted_products import grouped_products, weighted_products


def plainly(columns: ComplexArray, weight: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("kj,ka,kb->jab", weight, columns.conj(), columns).real)


@pytest.mark.parametrize("n_frf", [3, 9])  # fewer than columns, and more
@pytest.mark.parametrize("turned", [False, True])
def test_products_of_any_number_of_frfs_are_their_weighted_sums(n_frf: int, turned: bool) -> None:
    rng = np.random.default_rng(2)
    columns = rng.standard_normal((20, 6)) + 1j * rng.standard_normal((20, 6))
    if turned:
        columns[:, 1::2] = 1j * columns[:, ::2]
    weight = rng.uniform(0.0, 2.0, (20, n_frf)) * (rng.uniform(size=(20, 1)) > 0.2)
    found = weighted_products(columns, weight, paired_columns=turned)
    np.testing.assert_allclose(found, plainly(columns, weight), atol=1e-12)  # rounding of 20 terms
    np.testing.assert_array_equal(found, found.swapaxes(1, 2))


@pytest.mark.parametrize("turned", [False, True])
def test_products_of_groups_of_lines_are_those_of_their_weights(turned: bool) -> None:
    rng = np.random.default_rng(5)
    columns = rng.standard_normal((20, 6)) + 1j * rng.standard_normal((20, 6))
    if turned:
        columns[:, 1::2] = 1j * columns[:, ::2]
    weight = rng.uniform(0.5, 2.0, (4, 3)).repeat(5, axis=0) * rng.uniform(0.1, 10.0, (20, 1))
    weight[7] = 0.0
    groups = proportional_groups(weight)
    # blocks of lines that end within a group
    found = sum(
        grouped_products(columns[some], groups, some.start, paired_columns=turned)
        for some in (slice(0, 8), slice(8, 20))
    )
    np.testing.assert_allclose(found, plainly(columns, weight), rtol=1e-12, atol=1e-12)  # rounding of sums
