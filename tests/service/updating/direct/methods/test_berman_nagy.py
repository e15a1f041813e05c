"""Berman and Nagy's correction of mass and stiffness."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.fe.reduction import pencil_modes
from modallab.fe.structure import Structure
from tests.service.updating.direct.cases import BEAM, BOTH, HEAVIER, STIFFER, corrected, problem


@pytest.mark.parametrize("truth", [STIFFER, HEAVIER, BOTH])
def test_measured_modes_are_those_of_the_corrected_matrices(truth: Structure) -> None:
    given = problem(truth, 4)
    found = corrected("berman_nagy", given)
    np.testing.assert_allclose(given.shapes.T @ found.mass @ given.shapes, np.eye(4), atol=1e-10)  # rounding
    squares, shapes = pencil_modes(found.mass, found.stiffness)
    # rounding of the highest eigenvalue over the lowest, 1e-16 * 1e7
    np.testing.assert_allclose(squares[:4], given.squares, rtol=1e-8)
    alike = np.abs(np.diag(shapes[:, :4].T @ found.mass @ given.shapes))
    np.testing.assert_allclose(alike, 1.0, rtol=1e-8)


def test_the_corrected_matrices_are_symmetric_and_the_mass_stays_positive() -> None:
    found = corrected("berman_nagy", problem(BOTH, 4))
    for matrix in (found.mass, found.stiffness):
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * np.abs(matrix).max())
    assert np.linalg.eigvalsh(found.mass).min() > 0


def test_a_model_with_the_measured_modes_stays_as_it_is() -> None:
    given = problem(BEAM, 4)
    found = corrected("berman_nagy", given)
    for name in ("mass", "stiffness"):
        own = getattr(given, name)
        np.testing.assert_allclose(getattr(found, name), own, atol=1e-9 * np.abs(own).max())  # rounding


def test_all_modes_give_the_whole_truth() -> None:
    given = problem(BOTH, len(problem(BOTH, 1).dofs))
    found, truth = corrected("berman_nagy", given), problem(BEAM, 1, model=BOTH)
    for name in ("mass", "stiffness"):
        own = getattr(truth, name)
        np.testing.assert_allclose(getattr(found, name), own, atol=1e-6 * np.abs(own).max())  # rounding


def test_units_do_not_matter() -> None:
    given = problem(BOTH, 4)
    scale = np.where([dof.translational for dof in given.dofs], 1.0, 1e3)  # millimetres for rotations' lever
    even = np.outer(scale, scale)
    found = corrected("berman_nagy", given)
    other = corrected(
        "berman_nagy",
        replace(
            given,
            mass=given.mass * even,
            stiffness=given.stiffness * even,
            shapes=given.shapes / scale[:, None],
        ),
    )
    for name in ("mass", "stiffness"):
        ours = getattr(found, name)
        np.testing.assert_allclose(
            getattr(other, name) / even, ours, atol=1e-9 * np.abs(ours).max()
        )  # rounding
