from collections.abc import Callable

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.singly.leakage_feedback import feedback

Refit = Callable[[ComplexArray], tuple[ComplexArray, ComplexArray]]
TRUTH = np.array([[1e4 + 100j]])
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
    np.testing.assert_allclose(back.widening, 1.0)
    assert back.strength[0, 0] == pytest.approx(1.0)
    assert back.constant_error[0, 0] == pytest.approx(0.0, abs=1e-12)
    assert back.remainder[0, 0] == 0


def test_an_error_grows_as_the_fixed_point_of_a_linear_map_says() -> None:
    slope = np.array([[0.5, 0.2], [-0.1, 0.75]])
    back = feedback(linear(slope), TRUTH)
    exact = np.linalg.inv(np.eye(2) - slope)
    np.testing.assert_allclose(back.gain[0, 0], exact, rtol=1e-6)
    np.testing.assert_allclose(back.widening[0, 0], np.linalg.norm(exact, axis=1), rtol=1e-6)
    # along the modal constant's slope, both parts of the eigenvalue and of the constant alike
    expected = abs(CONSTANT) * np.linalg.norm(slope @ exact) / np.sqrt(2)
    assert back.constant_error[0, 0] == pytest.approx(expected, rel=1e-6)


def test_what_further_rounds_would_change_is_the_whole_way_to_where_they_end() -> None:
    begun = TRUTH + 30 - 10j
    back = feedback(linear(np.array([[0.9, 0.0], [0.0, 0.5]])), begun)
    assert back.remainder[0, 0] == pytest.approx(complex((TRUTH - begun)[0, 0]), rel=1e-6)


def test_feedback_that_lessens_errors_narrows_none_and_counts_as_strong() -> None:
    back = feedback(linear(np.diag([-9.0, 0.0])), TRUTH)
    np.testing.assert_allclose(back.widening, 1.0)
    assert back.strength[0, 0] == pytest.approx(10.0)


def test_lines_that_agree_with_any_mode_leave_a_large_but_finite_error() -> None:
    back = feedback(linear(np.eye(2)), TRUTH)
    assert back.widening.min() == pytest.approx(50.0, rel=1e-6)  # one over the least that 1 - J counts for
