import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.correlation.coordinate import comac, ecomac
from tests.service.correlation.cases import shapes


def test_comac_points_at_the_dof_that_differs() -> None:
    values = shapes(9)
    wrong = values.copy()
    wrong[2] = shapes(10)[2]
    found = comac(wrong, 3j * values)
    assert np.argmin(found) == 2
    assert comac(np.zeros((2, 1), complex), np.array([[0j], [1]])).tolist() == [1.0, 0.0]


@given(seed=st.integers(0, 1000), scale=st.complex_numbers(min_magnitude=1e-6, max_magnitude=1e6))
@settings(max_examples=50, deadline=None)
def test_neither_sees_a_scale_of_a_shape_and_both_stay_within_0_and_1(seed: int, scale: complex) -> None:
    one, other = shapes(seed), shapes(seed + 1)
    factors = np.array([scale, 1.0, -2.0, 1j])
    for criterion in (comac, ecomac):
        values = criterion(one, other)
        assert (values >= 0).all()
        assert (values <= 1).all()
        np.testing.assert_allclose(criterion(one * factors, other), values, rtol=1e-9, atol=1e-12)  # rounding
    np.testing.assert_allclose(ecomac(one * factors, one), 0.0, atol=1e-12)


def test_a_turned_sign_shows_in_the_enhanced_criterion_alone() -> None:
    values = shapes(9).real.astype(complex)
    turned = values.copy()
    turned[2] *= -1
    np.testing.assert_allclose(comac(turned, values), 1.0, atol=1e-12)
    found = ecomac(turned, values)
    # twice its own size, over twice the number of modes: the mean size there
    size = np.abs(values / np.abs(values).max(axis=0)).mean(axis=1)
    np.testing.assert_allclose(found[2], size[2], rtol=1e-9)
    np.testing.assert_allclose(np.delete(found, 2), 0.0, atol=1e-12)


def test_shapes_that_are_opposite_at_a_dof_that_moves_most_are_1_there() -> None:
    first, second = np.array([[1.0], [1.0], [1.0]]) + 0j, np.array([[1.0], [1.0], [-1.0]]) + 0j
    np.testing.assert_allclose(ecomac(first, second), [0.0, 0.0, 1.0])


def test_without_pairs_nothing_disagrees() -> None:
    assert ecomac(np.zeros((3, 0), complex), np.zeros((3, 0), complex)).tolist() == [0.0, 0.0, 0.0]
    assert ecomac(np.zeros((2, 1), complex), np.array([[1.0], [0.5]])) == pytest.approx([0.5, 0.25])
