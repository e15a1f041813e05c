"""The force balance."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.fe.structure import Structure
from tests.service.updating.direct.cases import BEAM, BOTH, HEAVIER, STIFFER, located, problem, wrong_rows


def shares(structure: Structure, count: int) -> np.ndarray:
    return np.asarray(located("modified_error_matrix", problem(structure, count)).dof_errors["force_balance"])


def rounding(structure: Structure, count: int) -> float:
    """How far the forces of a slow mode are from balance because its shape has 16 digits."""
    given = problem(structure, count)
    return float(np.finfo(float).eps * given.model_squares[-1] / given.squares[0])


@pytest.mark.parametrize("count", [1, 5])
@pytest.mark.parametrize("truth", [STIFFER, HEAVIER, BOTH])
def test_forces_are_out_of_balance_where_the_model_is_wrong_and_nowhere_else(
    truth: Structure, count: int
) -> None:
    found, wrong = shares(truth, count), wrong_rows(truth, "mass") | wrong_rows(truth, "stiffness")
    right = np.setdiff1d(np.arange(len(found)), list(wrong))
    assert found[list(wrong)].min() > 1e-3
    # rounding, worst where the clamp hardly lets a slow mode move
    assert found[right].max() < 1e-3 * found[list(wrong)].min()


def test_the_matrix_is_what_the_errors_of_mass_and_stiffness_make() -> None:
    given, truth = problem(BOTH, 4), problem(BEAM, 1, model=BOTH)
    stiffness, mass = truth.stiffness - given.stiffness, truth.mass - given.mass
    expected = (stiffness @ given.shapes - mass @ given.shapes * given.squares) @ given.shapes.T
    found = located("modified_error_matrix", given).matrices["force_balance"]
    np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())  # rounding


def test_a_model_with_the_measured_modes_is_in_balance() -> None:
    assert shares(BEAM, 5).max() < rounding(BEAM, 5)


def test_scale_and_sense_of_shapes_do_not_move_what_is_found() -> None:
    given = problem(BOTH, 1)
    other = located("modified_error_matrix", replace(given, shapes=-3.0 * given.shapes)).dof_errors[
        "force_balance"
    ]
    np.testing.assert_allclose(other, shares(BOTH, 1), atol=rounding(BOTH, 1))
