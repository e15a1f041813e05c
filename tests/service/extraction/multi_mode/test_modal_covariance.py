import numpy as np

from modallab.extraction.multi_mode.modal_covariance import (
    inverse_of_normal,
    propagated_covariance,
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
    found = with_undetermined_variances(covariance, np.array([1.0, 1.0, -1e-9, 0.0]), parameters)
    np.testing.assert_array_equal(found[:2, :2], covariance[:2, :2])
    np.testing.assert_array_equal(found[2:], [[0.0, 0.0, 25.0, 0.0], [0.0, 0.0, 0.0, 25.0]])
    determined = with_undetermined_variances(covariance, np.ones(4), parameters)
    np.testing.assert_array_equal(determined, covariance)


def test_parameters_that_nearly_depend_on_each_other_leave_no_negative_variance() -> None:
    rng = np.random.default_rng(0)
    slopes = rng.standard_normal((30, 6)) * [1e-6, 1.0, 1.0, 1.0, 1e3, 1.0]
    slopes[:, 3] = slopes[:, 2] * (1 + 1e-9)  # less than a normal matrix in double precision tells
    slopes[:, 5] = slopes[:, 1] - slopes[:, 2]
    normal = slopes.T @ slopes
    covariance = propagated_covariance(normal, inverse_of_normal(normal))
    scale = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(scale, scale)
    assert np.linalg.eigvalsh(correlation).min() > -1e-12  # six unit entries, rounded
    # what depends on nothing else keeps its variance
    alone = np.linalg.inv(slopes[:, [0, 1, 2, 4]].T @ slopes[:, [0, 1, 2, 4]])
    np.testing.assert_allclose(np.diag(covariance)[[0, 4]], np.diag(alone)[[0, 3]], rtol=1e-2)
    assert np.diag(covariance)[3] > 1e6 * np.diag(alone)[2]


def test_covariance_of_determined_parameters_is_the_inverse_of_their_information() -> None:
    slopes = np.random.default_rng(1).standard_normal((30, 4)) * [1e-8, 1.0, 1e3, 1e9]
    normal = slopes.T @ slopes
    covariance = propagated_covariance(normal, inverse_of_normal(normal))
    np.testing.assert_allclose(
        covariance * np.outer(*2 * [np.sqrt(np.diag(normal))]),
        np.linalg.inv(normal / np.outer(*2 * [np.sqrt(np.diag(normal))])),
        rtol=1e-9,
    )
