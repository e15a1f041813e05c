"""Baruch's stiffness correction."""

import numpy as np

from modallab.fe.reduction import pencil_modes
from tests.service.updating.direct.cases import BEAM, BOTH, STIFFER, corrected, problem


def test_measured_modes_are_those_of_the_corrected_matrices_where_the_mass_was_right() -> None:
    given = problem(STIFFER, 4)
    found = corrected("baruch", given)
    squares, shapes = pencil_modes(found.mass, found.stiffness)
    # rounding of the highest eigenvalue over the lowest, 1e-16 * 1e7
    np.testing.assert_allclose(squares[:4], given.squares, rtol=1e-8)
    alike = np.abs(np.diag(shapes[:, :4].T @ given.mass @ given.shapes))
    np.testing.assert_allclose(alike, 1.0, rtol=1e-8)


def test_the_mass_stays_and_shapes_give_way_where_it_is_wrong() -> None:
    given = problem(BOTH, 4)
    found = corrected("baruch", given)
    assert found.mass is given.mass
    squares, shapes = pencil_modes(found.mass, found.stiffness)
    np.testing.assert_allclose(squares[:4], given.squares, rtol=1e-8)
    assert np.abs(shapes[:, :4].T @ given.mass @ given.shapes).diagonal().min() < 0.9999


def test_a_model_with_the_measured_modes_stays_as_it_is() -> None:
    given = problem(BEAM, 4)
    # rounding of stiff rotations, relative to the largest entry
    np.testing.assert_allclose(
        corrected("baruch", given).stiffness, given.stiffness, atol=1e-9 * np.abs(given.stiffness).max()
    )
