from collections.abc import Callable

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.single_mode.leakage_feedback import feedback

Refit = Callable[[ComplexArray], tuple[ComplexArray, ComplexArray]]
TRUTH = np.array([[1e4 + 100j]])
HELD = np.eye(4)[None, None]  # covariance of fits to lines that are held
CONSTANT = 0.02 - 0.01j  # of a modal constant by an eigenvalue's error


def linear(slope: FloatArray) -> Refit:
    """Return fits about the truth that follow the mode they were corrected by with this slope."""

    def refit(eigenvalue: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        off = eigenvalue - TRUTH
        moved = slope @ np.array([off.real.ravel(), off.imag.ravel()])
        error = (moved[0] + 1j * moved[1]).reshape(off.shape)
        return TRUTH + error, 1.0 + CONSTANT * error

    return refit


def test_lines_that_are_corrected_by_no_mode_have_no_feedback() -> None:
    back = feedback(linear(np.zeros((2, 2))), TRUTH)
    np.testing.assert_allclose(back.gain[0, 0], np.eye(2), atol=1e-9)  # rounding of differences
    np.testing.assert_allclose(back.converged_covariance(HELD), HELD, atol=1e-9)  # rounding of differences
    assert back.strength[0, 0] == pytest.approx(1.0)
    assert back.remainder[0, 0] == 0


def test_an_error_grows_as_the_fixed_point_of_a_linear_map_says() -> None:
    slope = np.array([[0.5, 0.2], [-0.1, 0.75]])
    back = feedback(linear(slope), TRUTH)
    exact = np.linalg.inv(np.eye(2) - slope)
    np.testing.assert_allclose(back.gain[0, 0], exact, rtol=1e-6)
    rng = np.random.default_rng(0)
    errors = rng.standard_normal((100, 4)) @ np.diag([2.0, 1.0, 0.1, 0.1])  # of fits to lines that are held
    settled = errors.copy()
    settled[:, :2] = errors[:, :2] @ exact.T
    # the modal constant goes along with the mode that its lines are corrected by
    along = CONSTANT * ((settled[:, :2] @ slope.T) @ np.array([1, 1j]))
    settled[:, 2:] += np.stack([along.real, along.imag], axis=1)
    expected = settled.T @ settled
    found = back.converged_covariance((errors.T @ errors)[None, None])[0, 0]
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6 * expected.max())  # of differences


def test_what_further_rounds_would_change_is_the_whole_way_to_where_they_end() -> None:
    begun = TRUTH + 30 - 10j
    back = feedback(linear(np.array([[0.9, 0.0], [0.0, 0.5]])), begun)
    assert back.remainder[0, 0] == pytest.approx(complex((TRUTH - begun)[0, 0]), rel=1e-6)


def test_feedback_that_lessens_errors_counts_as_strong() -> None:
    back = feedback(linear(np.diag([-9.0, 0.0])), TRUTH)
    assert back.converged_covariance(HELD)[0, 0, 0, 0] == pytest.approx(0.01, rel=1e-6)
    assert back.strength[0, 0] == pytest.approx(10.0)


def test_lines_that_agree_with_any_mode_leave_a_large_but_finite_error() -> None:
    back = feedback(linear(np.eye(2)), TRUTH)
    # one over the least that 1 - J counts for, squared
    np.testing.assert_allclose(back.converged_covariance(HELD)[0, 0, :2, :2], 2500 * np.eye(2), rtol=1e-6)
