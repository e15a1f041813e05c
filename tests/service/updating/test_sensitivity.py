"""Derivatives of all elements at once against exact ones, one element at a time."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import IntArray
from modallab.core.dof import Dof
from modallab.fe.assembly import Assembly, coefficients_of
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.modes import modal_basis
from modallab.fe.structure import Structure
from modallab.fe.system import SMALL
from modallab.updating.parameterisation import Parameterisation, Part, parameterise
from modallab.updating.sensitivity import Derivatives, derivatives, part_matrices
from tests.service.updating.cases import long_cantilever


def found(
    structure: Structure, parameters: Parameterisation, modes: IntArray, dofs: tuple[Dof, ...]
) -> Derivatives:
    assembly = Assembly(structure)
    system = assembly.system()
    limit = np.inf if len(system.dofs) < SMALL else 1600.0
    basis = modal_basis(system.mass, system.stiffness, None, None, system.rigid, frequency_max=limit)
    parts = part_matrices(assembly, coefficients_of(structure), parameters)
    return derivatives(basis, basis.n_rigid_body + modes, system.selection(dofs), parts)


def by_nelson(
    structure: Structure, parameters: Parameterisation, modes: IntArray, dofs: tuple[Dof, ...]
) -> Derivatives:
    """Solve for every derivative exactly: (K - lambda M) dphi = -(dK - lambda dM - dlambda M) phi.

    Nelson (1976), bordered by the mass normalisation instead of by striking out a row.
    """
    assembly = Assembly(structure)
    system = assembly.system()
    basis = modal_basis(system.mass, system.stiffness, None, None, system.rigid)
    sensors, groups = system.selection(dofs), parameters.groups(structure)
    squares, shapes = [], []
    for r in basis.n_rigid_body + modes:
        square, phi = basis.eigenvalues.real[r], basis.shapes[:, r].real
        heavy = system.mass @ phi
        border = np.block(
            [
                [system.stiffness.toarray() - square * system.mass.toarray(), -heavy[:, None]],
                [heavy, np.zeros(1)],
            ]
        )
        for macro, row in zip(parameters.macros, groups, strict=True):
            weight = row[:, None, None]
            stiff = macro.part is not Part.MASS
            chosen = {
                Part.MASS: assembly.mass,
                Part.STIFFNESS: assembly.axial + assembly.bending,
                Part.AXIAL: assembly.axial,
                Part.BENDING: assembly.bending,
            }[macro.part]
            load = assembly.matrix(weight * chosen) @ phi
            right = np.append(-load, 0.0) if stiff else np.append(square * load, -0.5 * phi @ load)
            solved = np.linalg.solve(border, right)
            squares.append(solved[-1])
            shapes.append(sensors.T @ solved[:-1])
    n = len(parameters.macros)
    table = np.array(shapes).reshape(len(modes), n, len(dofs)).transpose(2, 0, 1)
    return Derivatives(np.array(squares).reshape(len(modes), n), table)


BAY_DOFS = (Dof(1, "X"), Dof(8, "Y", -1), Dof(26, "X"))
BEAM_DOFS = (Dof(1, "Y"), Dof(9, "Y"), Dof(21, "RZ"))
CASES = {
    "bay by parts": ("bay", parameterise([(5,), (25, 26), (31,)], ("mass", "axial", "bending")), BAY_DOFS),
    "bay by macro elements": ("bay", parameterise([(1, 2, 3), (12, 13)]), BAY_DOFS),
    "free beam": ("chapter-5-beam", parameterise([(1, 2), (11,)]), BEAM_DOFS),
    "cantilever": ("cantilever", parameterise([(1, 2), (11,)]), BEAM_DOFS[1:]),
}


@pytest.mark.parametrize("case", CASES)
def test_derivatives_are_those_of_nelson(case: str) -> None:
    name, parameters, dofs = CASES[case]
    structure, modes = STRUCTURES[name](), np.array([0, 1, 4])
    ours = found(structure, parameters, modes, dofs)
    exact = by_nelson(structure, parameters, modes, dofs)
    # the modal sum is whole, so both are exact: rounding, times the condition of K - lambda M
    for one, other in ((ours.eigenvalues, exact.eigenvalues), (ours.shapes, exact.shapes)):
        np.testing.assert_allclose(one, other, atol=1e-6 * np.abs(other).max())


def test_coefficients_that_members_carry_scale_their_derivatives() -> None:
    structure = STRUCTURES["cantilever"]()
    heavier = replace(structure.members[4], mass_factor=2.0)
    members = (*structure.members[:4], heavier, *structure.members[5:])
    changed = replace(structure, members=members)
    parameters, modes = parameterise([(5,)], ("mass",)), np.array([0, 1])
    exact = by_nelson(changed, parameters, modes, BEAM_DOFS[1:])
    ours = found(changed, parameters, modes, BEAM_DOFS[1:])
    np.testing.assert_allclose(ours.eigenvalues, 2 * exact.eigenvalues, rtol=1e-6)  # of its coefficient


def test_a_large_structure_is_differentiated_without_all_its_modes() -> None:
    structure = long_cantilever()
    assert len(structure.dofs) >= SMALL
    parameters, modes = parameterise([tuple(range(1, 14)), tuple(range(60, 80))]), np.array([0, 1, 2])
    dofs = (Dof(40, "Y"), Dof(131, "Y"))
    ours = found(structure, parameters, modes, dofs)
    exact = by_nelson(structure, parameters, modes, dofs)
    np.testing.assert_allclose(ours.eigenvalues, exact.eigenvalues, rtol=1e-4)
    # either solution may hold a mode upside down
    sense = np.sign((ours.shapes * exact.shapes).sum(axis=(0, 2)))[:, None]
    # modes from 1600 Hz up answer statically: off by (60 Hz/1600 Hz)^2 = 0.1 % of what they add
    np.testing.assert_allclose(sense * ours.shapes, exact.shapes, atol=1e-4 * np.abs(exact.shapes).max())
