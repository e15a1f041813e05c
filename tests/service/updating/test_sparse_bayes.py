"""Linear equations with a prior: what the data call for, and no more."""

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.updating.sparse_bayes import Equations, Prior, sparse_bayes

RNG = np.random.default_rng(7)
ROWS = RNG.standard_normal((200, 40))


def equations(truth: FloatArray, noise: float) -> Equations:
    errors = np.random.default_rng(1).standard_normal(len(ROWS))
    return Equations(ROWS, ROWS @ truth + noise * errors, np.zeros(len(ROWS), int), np.full(1, 1e-9))


def test_no_block_of_values_is_smaller_than_its_floor() -> None:
    values = np.array([3.0, 4.0, 0.0, 0.1])
    linear = Equations(np.ones((4, 1)), values, np.array([0, 0, 1, 1]), np.ones(2))
    np.testing.assert_allclose(linear.mean_squares, [12.5, 1.0])


def test_a_sparse_prior_keeps_the_few_that_are_not_zero() -> None:
    truth = np.zeros(40)
    truth[[3, 17]] = 0.5, -0.2
    found = sparse_bayes(equations(truth, 0.05), Prior.SPARSE, np.full(40, 0.1), np.ones(1))
    free = np.linalg.lstsq(ROWS, equations(truth, 0.05).values, rcond=None)[0]
    assert set(np.flatnonzero(np.abs(found.mean) > 0.02)) == {3, 17}
    assert (found.mean[~found.is_active] == 0.0).all()
    assert np.linalg.norm(found.mean - truth) < np.linalg.norm(free - truth)


def test_the_scatter_of_rows_is_found_from_what_is_left() -> None:
    truth, block = np.eye(5)[2], np.repeat([0, 1], 100)
    rows, errors = ROWS[:, :5], np.random.default_rng(1).standard_normal(200)
    values = rows @ truth + np.where(block == 0, 0.05, 0.5) * errors
    found = sparse_bayes(
        Equations(rows, values, block, np.full(2, 1e-9)), Prior.SPARSE, np.full(5, 0.1), np.ones(2)
    )
    # a standard deviation from 100 rows is known to 1/sqrt(200) = 7 %: three of these
    np.testing.assert_allclose(np.sqrt(found.block_variances), [0.05, 0.5], rtol=0.21)
    assert found.mean[2] == pytest.approx(1.0, abs=0.02)  # three standard errors of the good half


def test_a_common_prior_finds_the_width_that_unknowns_were_drawn_with() -> None:
    truth = 0.3 * np.random.default_rng(2).standard_normal(40)
    found = sparse_bayes(equations(truth, 0.1), Prior.COMMON, np.full(40, 0.1), np.ones(1))
    # 40 draws know their width to 1/sqrt(80) = 11 %: three of these
    assert np.sqrt(found.prior_variances[0]) == pytest.approx(0.3, rel=0.34)
    assert (found.prior_variances == found.prior_variances[0]).all()


def test_a_given_width_is_left_and_the_posterior_is_that_of_ridge_regression() -> None:
    truth, width = 0.3 * np.random.default_rng(2).standard_normal(40), 0.04
    one = equations(truth, 0.1)
    floors = Equations(one.matrix, one.values, one.block, np.full(1, 10.0))  # errors no less than stated
    found = sparse_bayes(floors, Prior.RANGE, np.full(40, width), np.full(1, 100.0))
    inside = np.linalg.inv(ROWS.T @ ROWS / 100.0 + np.eye(40) / width)
    # the same matrix by another form: rounding of a condition number of about 2
    np.testing.assert_allclose(found.covariance, inside, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.mean, inside @ (ROWS.T @ one.values) / 100.0, rtol=1e-9)


def test_more_unknowns_than_rows_have_a_finite_answer() -> None:
    few = Equations(ROWS[:10], ROWS[:10] @ np.eye(40)[4], np.zeros(10, int), np.full(1, 1e-6))
    found = sparse_bayes(few, Prior.SPARSE, np.full(40, 0.1), np.ones(1))
    assert np.isfinite(found.mean).all()
    # ten exact rows are met: to a hundred of the floor
    np.testing.assert_allclose(ROWS[:10] @ found.mean, few.values, atol=1e-4)


def test_equations_of_nothing_leave_everything_out() -> None:
    nothing = Equations(np.zeros((5, 3)), np.zeros(5), np.zeros(5, int), np.full(1, 1e-6))
    found = sparse_bayes(nothing, Prior.SPARSE, np.full(3, 0.1), np.ones(1))
    assert not found.is_active.any()
    assert (found.mean == 0.0).all()
