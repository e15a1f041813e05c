"""Arrays of domain types are copies that nobody can change."""

import numpy as np
import pytest

from modallab.core.arrays import frozen, logarithm
from modallab.core.errors import InvalidInputError


def test_a_frozen_array_is_a_copy_that_cannot_be_written() -> None:
    given = np.zeros((2, 3))
    kept = frozen(given, float, (2, None))
    given[0, 0] = 5.0
    assert kept[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        kept[0, 0] = 1.0


@pytest.mark.parametrize("shape", [(3, 2), (2,), (None, None, None)])
def test_another_shape_is_refused_with_the_one_expected(shape: tuple[int | None, ...]) -> None:
    with pytest.raises(InvalidInputError) as caught:
        frozen(np.zeros((2, 3)), float, shape, name="shapes")
    assert caught.value.context == {"field": "shapes", "value": [2, 3], "allowed": list(shape)}


@pytest.mark.parametrize("bad", [np.nan, np.inf, complex(0, np.nan)])
def test_what_is_not_finite_is_refused_with_its_place(bad: complex) -> None:
    values = np.zeros((2, 3), complex)
    values[1, 2] = bad
    with pytest.raises(InvalidInputError) as caught:
        frozen(values, complex, (2, 3), name="values")
    assert caught.value.context == {"field": "values", "index": [1, 2]}


def test_the_logarithm_is_that_of_the_library_on_all_sides_of_0_and_at_any_size() -> None:
    angle = np.linspace(-np.pi, np.pi, 37)
    values = np.multiply.outer([1e-150, 1e-9, 1 - 1e-9, 1.0, 3.0, 1e9, 1e150], np.exp(1j * angle))
    np.testing.assert_allclose(logarithm(values), np.log(values), rtol=1e-15, atol=2e-16)  # rounding
