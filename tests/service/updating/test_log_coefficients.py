"""Coefficients by their logarithms."""

import numpy as np

from modallab.updating.log_coefficients import from_log_changes, log_changes, log_derivatives
from modallab.updating.parameterisation import parameterise

THREE = parameterise([(1,)], ("mass", "stiffness", "damping"))


def test_a_third_and_three_times_are_as_far_from_no_change() -> None:
    far = log_changes(THREE, np.array([1 / 3, 3.0, 0.02]))
    np.testing.assert_allclose(far, [-np.log(3), np.log(3), 0.02])
    np.testing.assert_allclose(from_log_changes(THREE, far), [1 / 3, 3.0, 0.02])
    np.testing.assert_array_equal(log_changes(THREE, THREE.nominal), 0.0)
    np.testing.assert_array_equal(from_log_changes(THREE, np.zeros(3)), THREE.nominal)


def test_coefficients_stay_above_zero_and_within_bounds() -> None:
    np.testing.assert_allclose(from_log_changes(THREE, np.array([-50.0, 50.0, -5.0])), [0.05, 10.0, -1.0])


def test_slopes_are_derivatives() -> None:
    at, step = np.array([0.2, -0.4, 0.03]), 1e-6
    expected = (from_log_changes(THREE, at + step) - from_log_changes(THREE, at - step)) / (2 * step)
    # second differences: step^2 and rounding over step
    np.testing.assert_allclose(log_derivatives(THREE, from_log_changes(THREE, at)), expected, rtol=1e-8)
