"""Modes of a dense solution, solved for once more: nearer to what their matrices say, and still modes."""

import numpy as np
import pytest
from scipy.linalg import eigh

from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.eigen_refinement import refined_modes
from modallab.fe.modes import ModalBasis, modal_basis, undamped_basis
from modallab.fe.system import DynamicSystem


def off_balance(system: DynamicSystem, basis: ModalBasis) -> float:
    """Return the largest force that the first elastic mode leaves over, N."""
    r = basis.n_rigid_body
    shape, square = basis.shapes[:, r].real, basis.eigenvalues[r].real
    return float(np.abs(system.stiffness @ shape - square * (system.mass @ shape)).max())


@pytest.mark.parametrize("name", ["bay", "chapter-5-beam", "cantilever"])
def test_low_modes_come_nearer_to_balance_and_all_stay_orthonormal(name: str) -> None:
    system = assemble(STRUCTURES[name]())
    rough = undamped_basis(system.mass, system.stiffness, system.rigid)
    fine = modal_basis(system.mass, system.stiffness, None, None, system.rigid)
    assert off_balance(system, fine) < off_balance(system, rough)
    gram = fine.shapes.T @ (system.mass @ fine.shapes)
    np.testing.assert_allclose(gram, np.eye(len(gram)), atol=1e-8)  # rounding of the eigen-solution
    # the dense solution loses the ratio of the largest eigenvalue to them, 1e8 and more, times 1e-16
    np.testing.assert_allclose(fine.frequencies, rough.frequencies, rtol=1e-6)
    along = np.einsum("ij,ij->j", rough.shapes.real, system.mass @ fine.shapes.real)
    assert (along > 0).all()  # each in its old sense


def test_a_mechanism_is_left_as_it_was_found() -> None:
    mass = np.eye(3)
    stiffness = np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    squares, shapes = eigh(stiffness, mass)
    squares[0] = -1e-9  # of rounding
    after, same = refined_modes(mass, stiffness, squares, shapes, 0)
    np.testing.assert_array_equal(after, squares)
    np.testing.assert_array_equal(same, shapes)
