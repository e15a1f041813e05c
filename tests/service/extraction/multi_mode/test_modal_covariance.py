import numpy as np

from modallab.extraction.multi_mode.modal_covariance import unit_diagonal, with_undetermined_variances


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
    found = with_undetermined_variances(covariance, np.array([1.0, 1.0, -1e-9, 0.0]), parameters)
    np.testing.assert_array_equal(found[:2, :2], covariance[:2, :2])
    np.testing.assert_array_equal(found[2:], [[0.0, 0.0, 25.0, 0.0], [0.0, 0.0, 0.0, 25.0]])
    determined = with_undetermined_variances(covariance, np.ones(4), parameters)
    np.testing.assert_array_equal(determined, covariance)
