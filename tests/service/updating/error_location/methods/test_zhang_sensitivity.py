"""Zhang's first method."""

import numpy as np

from modallab.updating.error_location.method import LOCATORS, LinearProblem


def test_a_large_change_that_nothing_feels_is_not_suspected() -> None:
    sensitivity = np.array([[1.0, 0.0], [0.0, 1e-3]])
    found = LOCATORS["zhang_sensitivity"](
        LinearProblem(sensitivity, np.array([0.5, 4e-4])), threshold=0.08, jump=1e6
    )
    np.testing.assert_allclose(found.change, [0.5, 0.4])
    assert found.suspected.tolist() == [True, False]
    np.testing.assert_allclose(found.weight, [1.0, 8e-4], rtol=1e-6)  # shares of |delta| = 0.5 (1 + 3e-7)


def test_columns_that_are_alike_share_an_error_between_them() -> None:
    rng = np.random.default_rng(0)
    column = rng.standard_normal(20)
    found = LOCATORS["zhang_sensitivity"](
        LinearProblem(np.column_stack([column, column]), 0.6 * column), threshold=0.08, jump=1e3
    )
    assert found.rank == 1
    np.testing.assert_allclose(found.change, 0.3)
