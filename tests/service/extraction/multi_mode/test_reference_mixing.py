"""FRFs of several references share few columns: what follows from these is what all of them at once give."""

from dataclasses import dataclass

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.multi_mode.modal_covariance import parameter_weights
from modallab.extraction.multi_mode.participation import SharedShapeBasis
from modallab.extraction.multi_mode.pole_basis import BASES
from modallab.extraction.multi_mode.variable_projection import (
    LinearSolution,
    ScaledLines,
    scale_lines,
    solve_linear,
)
from modallab.extraction.options import Damping

LAWS = list(Damping)
N_REF, N_DOF, N_MODES = 3, 2, 2
OMEGA: FloatArray = np.linspace(20.0, 60.0, 40)
EIGENVALUE: ComplexArray = np.array([30.0**2 * (1 + 0.1j), 45.0**2 * (1 + 0.06j)])


@dataclass(frozen=True)
class Case:
    lines: ScaledLines
    basis: SharedShapeBasis
    parameters: FloatArray

    def linear(self, moved: FloatArray | float = 0.0) -> LinearSolution:
        return solve_linear(self.lines, self.basis, self.parameters + moved)


def case(damping: Damping) -> Case:
    rng = np.random.default_rng(4)
    shape = (len(OMEGA), N_DOF * N_REF)
    response = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    lines = scale_lines(OMEGA, response, rng.uniform(0.5, 2.0, shape), N_REF)
    reach = rng.standard_normal((N_MODES, N_REF)) + 1j * rng.standard_normal((N_MODES, N_REF))
    basis = SharedShapeBasis(damping, np.abs(reach).argmax(axis=1), N_REF)
    law = BASES[damping].parameters(np.asarray(EIGENVALUE / lines.unit**2))
    return Case(lines, basis, basis.start(law, reach))


def mode(damping: Damping, omega: FloatArray, parameters: FloatArray, shape: complex) -> ComplexArray:
    """Return the receptance of a mode as the law defines it, of a residue `shape` over `s - conj(s)`."""
    stiffness, loss = parameters[:2].tolist()
    if damping is Damping.STRUCTURAL:
        return np.asarray(shape / (stiffness + 1j * loss - omega**2))
    pole = -loss / 2 + 1j * np.sqrt(stiffness - loss**2 / 4)
    across = pole - pole.conjugate()
    return np.asarray(
        shape / (across * (1j * omega - pole))
        + np.conj(shape) / (np.conj(across) * (1j * omega - pole.conjugate()))
    )


def of_all_references(made: Case, dof: int) -> tuple[FloatArray, FloatArray]:
    """Return the weighted columns that a DoF's FRFs share and the weighted lines, as one real system."""
    lines, reach = made.lines, made.basis.participation(made.parameters)
    blocks, right = [], []
    for k in range(N_REF):
        frf = dof * N_REF + k
        root = np.sqrt(lines.weight[:, frf])
        columns = [
            mode(made.basis.damping, lines.omega, made.parameters[r], shape * reach[r, k])
            for r in range(N_MODES)
            for shape in (1.0, 1.0j)
        ]
        for other in range(N_REF):
            own: ComplexArray = np.full(len(OMEGA), float(other == k), complex)
            below = np.asarray(-own / lines.omega**2, complex)
            columns += [own, 1j * own, below, 1j * below]
        blocks.append(root[:, None] * np.stack(columns, axis=1))
        right.append(root * lines.response[:, frf])
    matrix, lot = np.concatenate(blocks), np.concatenate(right)
    return np.concatenate([matrix.real, matrix.imag]), np.concatenate([lot.real, lot.imag])


@pytest.mark.parametrize("damping", LAWS)
def test_unknowns_are_those_of_all_lines_of_all_references_in_one_system(damping: Damping) -> None:
    made = case(damping)
    assert not made.lines.fixed_poles
    linear = made.linear()
    for dof in range(N_DOF):
        matrix, right = of_all_references(made, dof)
        unknowns = np.linalg.lstsq(matrix, right)[0]
        # rounding of normal equations whose columns are far from parallel
        np.testing.assert_allclose(linear.coefficients[dof], unknowns, rtol=1e-9, atol=1e-11)
        assert linear.misfit[dof] == pytest.approx(((right - matrix @ unknowns) ** 2).sum(), rel=1e-10)
        own = np.linalg.inv(matrix.T @ matrix)
        np.testing.assert_allclose(linear.inverse[dof], own, rtol=1e-8, atol=1e-10 * np.abs(own).max())


@pytest.mark.parametrize("damping", LAWS)
def test_slopes_of_the_misfit_are_its_differences(damping: Damping) -> None:
    made = case(damping)
    linear = made.linear()
    slope = -2 * np.einsum("jps,js->p", parameter_weights(made.basis, linear), linear.gradient)
    differences = np.empty_like(made.parameters)
    for at in np.ndindex(made.parameters.shape):
        step = np.zeros_like(made.parameters)
        step[at] = 1e-5
        differences[at] = (made.linear(step).misfit - made.linear(-step).misfit).sum() / 2e-5
    # central differences: third derivatives times 1e-10, and rounding of misfits over 1e-5
    np.testing.assert_allclose(slope, differences.ravel(), rtol=1e-6, atol=1e-7 * np.abs(slope).max())
