import numpy as np

from modallab.extraction.multi_mode.modal_covariance import (
    determined_parameters,
    unit_diagonal,
    with_undetermined_variances,
)


def test_a_parameter_of_which_rounding_leaves_less_than_nothing_stands_by_itself() -> None:
    normal = np.array([[4.0, 1.0, 1e200], [1.0, 9.0, 2.0], [1e200, 2.0, -5e9]])
    even, length = unit_diagonal(normal)
    np.testing.assert_allclose(length, [2.0, 3.0, 1.0])
    np.testing.assert_allclose(even, [[1.0, 1 / 6, 0.0], [1 / 6, 1.0, 0.0], [0.0, 0.0, 1.0]])


def test_parameters_that_lines_tell_are_brought_to_one_length() -> None:
    rng = np.random.default_rng(0)
    slopes = rng.standard_normal((20, 4)) * [1e-8, 1.0, 1e3, 1e9]
    even, length = unit_diagonal(slopes.T @ slopes)
    np.testing.assert_allclose(np.diag(even), 1.0)
    np.testing.assert_allclose(even * np.outer(length, length), slopes.T @ slopes)


def test_parameters_that_no_line_determines_are_unknown_by_their_own_size() -> None:
    parameters = np.array(
        [[2.0, 0.1], [5.0, 0.3]]
    )  # two modes, the second of which rounding alone determines
    covariance = np.array(
        [
            [1e-6, 1e-7, 1.0, 1.0],
            [1e-7, 1e-6, 1.0, 1.0],
            [1.0, 1.0, -3.0, 1.0],
            [1.0, 1.0, 1.0, -2.0],
        ]
    )
    found = with_undetermined_variances(covariance, np.array([True, True, False, False]), parameters)
    np.testing.assert_array_equal(found[:2, :2], covariance[:2, :2])
    np.testing.assert_array_equal(found[2:], [[0.0, 0.0, 25.0, 0.0], [0.0, 0.0, 0.0, 25.0]])
    determined = with_undetermined_variances(covariance, np.ones(4, bool), parameters)
    np.testing.assert_array_equal(determined, covariance)


def test_information_that_is_rounding_determines_nothing() -> None:
    rng = np.random.default_rng(0)
    slopes = rng.standard_normal((30, 5))
    normal = slopes.T @ slopes
    # two parameters of which a difference of products leaves rounding alone
    rounding = np.array([[1e-12, 3e-12], [3e-12, 1e-12]])
    normal[3:, :3], normal[:3, 3:] = 0.0, 0.0
    normal[3:, 3:] = rounding
    np.testing.assert_array_equal(determined_parameters(normal)[:3], True)
    assert not determined_parameters(normal)[3:].all()


def test_all_parameters_of_a_positive_normal_matrix_are_determined() -> None:
    slopes = np.random.default_rng(1).standard_normal((30, 4)) * [1e-8, 1.0, 1e3, 1e9]
    slopes[:, 3] = 1e3 * slopes[:, 1] + 1e-2 * slopes[:, 3] / 1e9  # nearly dependent: far above rounding
    assert determined_parameters(slopes.T @ slopes).all()


def test_parameters_are_left_out_until_rounding_is_no_longer_seen() -> None:
    # a broad pole between two others: its eigenvalue is positive, and smaller than the negative one
    even = np.diag([1.0, 1.0, 1.0, 1.0])
    even[0, 1] = even[1, 0] = 1.2  # eigenvalues -0.2 and 2.2
    even[2, 3] = even[3, 2] = 0.95  # eigenvalues 0.05 and 1.95
    assert determined_parameters(even).sum() == 2
