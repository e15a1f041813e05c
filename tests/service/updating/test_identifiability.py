"""What data say of coefficients, and the words for what they do not."""

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.updating.identifiability import Identifiability, describe_ambiguity, identify
from modallab.updating.parameterisation import MacroElement, Parameterisation, Part, parameterise
from modallab.updating.solve import balanced_step

FOUR = parameterise([(1,), (2,)])  # mass of 1 and 2, stiffness of 1 and 2


def told(
    matrix: FloatArray,
    values: FloatArray | None = None,
    errors: float | None = 0.1,
    parameters: Parameterisation = FOUR,
) -> Identifiability:
    n = len(matrix)
    step = balanced_step(matrix, np.zeros(n), np.ones(n))
    at = parameters.nominal if values is None else values
    rows = None if errors is None else np.full(n, errors)
    return identify(parameters, at, step, np.zeros(n), rows, within=0.3)


def test_covariance_and_intervals_are_those_of_least_squares() -> None:
    matrix, values = np.random.default_rng(0).standard_normal((30, 4)), np.array([1.0, 1.5, 2.0, 0.7])
    found = told(matrix, values)
    expected = 0.01 * np.linalg.inv(matrix.T @ matrix)
    assert found.covariance is not None
    np.testing.assert_allclose(found.covariance, expected, rtol=1e-9)  # rounding
    ends = values[:, None] * np.exp(np.outer(np.sqrt(np.diag(expected)) / values, [-1.96, 1.96]))
    np.testing.assert_allclose(found.intervals, ends, rtol=1e-5)  # 1.96 is rounded
    assert found.directions == ()
    assert found.unidentified == ()


def test_mass_and_stiffness_that_only_show_together_are_named() -> None:
    one = np.array([1.0, 0.0, -1.0, 0.0])  # an element of twice the mass and stiffness looks the same
    matrix = np.array([one, [0, 1, 0, 0], [0, 0, 0, 1], 2 * one, [0, 1, 0, 1]], float)
    found = told(matrix)
    assert found.rank == 3
    (direction,) = found.directions
    assert direction.words == "mass and stiffness of 1 cannot be told apart by these data"
    assert direction.standard_error is None
    np.testing.assert_allclose(direction.shares, [np.sqrt(0.5)] * 2, atol=1e-9)  # rounding
    assert [str(macro) for macro in found.unidentified] == ["mass of 1", "stiffness of 1"]
    np.testing.assert_array_equal(found.intervals[[0, 2]], [[0.05, 10.0]] * 2)  # all that bounds admit
    assert (found.intervals[[1, 3], 1] < 2.0).all()


def test_a_direction_that_hardly_shows_has_its_standard_error() -> None:
    matrix = np.diag([10.0, 10.0, 10.0, 0.1])
    found = told(np.vstack([matrix, matrix]))
    (direction,) = found.directions
    assert direction.words == "stiffness of 2 hardly shows in these data"
    assert direction.standard_error == pytest.approx(0.1 / (0.1 * np.sqrt(2)))
    assert [str(macro) for macro in found.unidentified] == ["stiffness of 2"]


def test_unseen_directions_are_turned_to_few_coefficients_each() -> None:
    # nothing is known of three: any turn of these directions would do, one that says who is clearest
    matrix = np.zeros((5, 4))
    matrix[:, 1] = 1.0
    words = {one.words for one in told(matrix).directions}
    assert words == {
        "mass of 1 does not show in these data",
        "stiffness of 1 does not show in these data",
        "stiffness of 2 does not show in these data",
    }


def test_relative_changes_are_told_where_coefficients_are_far_from_one() -> None:
    one = np.array([1.0, 0.0, -2.0, 0.0])  # mass 2, stiffness 1: both 10 % up looks the same
    matrix = np.array([one, [0, 1, 0, 0], [0, 0, 0, 1], 3 * one], float)
    (direction,) = told(matrix, np.array([2.0, 1.0, 1.0, 1.0])).directions
    np.testing.assert_allclose(direction.shares, [np.sqrt(0.5)] * 2, atol=1e-9)  # rounding


def test_without_anything_to_judge_errors_by_intervals_are_the_bounds() -> None:
    found = told(np.eye(4), errors=None)
    assert found.covariance is None
    np.testing.assert_array_equal(found.intervals, [[0.05, 10.0]] * 4)
    assert found.unidentified == ()


def test_loss_factors_are_judged_by_what_is_added() -> None:
    damping = parameterise([(1,)], ("damping",))
    found = told(np.ones((4, 1)), np.array([0.02]), 0.01, damping)
    # four rows: half the error of one
    np.testing.assert_allclose(found.intervals, [[0.02 - 0.0098, 0.02 + 0.0098]], atol=1e-6)


def test_words_gather_members_and_parts() -> None:
    mass, stiffness = Part.MASS, Part.STIFFNESS
    several = [MacroElement((n,), part) for part in (mass, stiffness) for n in (10, 11, 12)]
    assert (
        describe_ambiguity(several, is_null=True)
        == "mass and stiffness of 10-12 cannot be told apart by these data"
    )
    mixed = [MacroElement((7, 8), mass), MacroElement((3,), stiffness)]
    expected = "mass of 7, 8 and stiffness of 3 can hardly be told apart by these data"
    assert describe_ambiguity(mixed, is_null=False) == expected
