"""Coefficients by their logarithms."""

import numpy as np

from modallab.updating.log_coefficients import changed, changes, slopes
from modallab.updating.parameterisation import parameterise

THREE = parameterise([(1,)], ("mass", "stiffness", "damping"))


def test_a_third_and_three_times_are_as_far_from_no_change() -> None:
    far = changes(THREE, np.array([1 / 3, 3.0, 0.02]))
    np.testing.assert_allclose(far, [-np.log(3), np.log(3), 0.02])
    np.testing.assert_allclose(changed(THREE, far), [1 / 3, 3.0, 0.02])
    np.testing.assert_array_equal(changes(THREE, THREE.unchanged), 0.0)
    np.testing.assert_array_equal(changed(THREE, np.zeros(3)), THREE.unchanged)


def test_coefficients_stay_above_zero_and_within_bounds() -> None:
    np.testing.assert_allclose(changed(THREE, np.array([-50.0, 50.0, -5.0])), [0.05, 10.0, -1.0])


def test_slopes_are_derivatives() -> None:
    at, step = np.array([0.2, -0.4, 0.03]), 1e-6
    expected = (changed(THREE, at + step) - changed(THREE, at - step)) / (2 * step)
    # second differences: step^2 and rounding over step
    np.testing.assert_allclose(slopes(THREE, changed(THREE, at)), expected, rtol=1e-8)
