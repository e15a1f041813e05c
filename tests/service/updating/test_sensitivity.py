"""Derivatives of modes against the complex step: matrices with a coefficient 1e-30 i away, solved again."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.linalg import eigh

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import Assembly, coefficients_of
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.modes import ModalBasis, modal_basis
from modallab.fe.plate import plate
from modallab.fe.settings import EIGENSOLUTION
from modallab.fe.structure import Material, Structure
from modallab.updating.parameterisation import Parameterisation, Part, parameterise
from modallab.updating.sensitivity import PartMatrices, derivatives, part_matrices, subspace_derivatives
from modallab.updating.truncation import HigherModes
from tests.service.updating.cases import long_cantilever

STEP = 1e-30  # of a coefficient, imaginary: nothing cancels, so it can be as small as one likes
EXACT = 1e-8  # of the largest derivative


@dataclass(frozen=True, eq=False)
class Case:
    """A structure with coefficients, its modes as far as an update knows them, and its sensors."""

    structure: Structure
    parameters: Parameterisation
    dofs: tuple[Dof, ...]
    limit: float = np.inf  # Hz

    @property
    def assembly(self) -> Assembly:
        return Assembly(self.structure)

    @property
    def basis(self) -> ModalBasis:
        system = self.assembly.system()
        return modal_basis(system.mass, system.stiffness, None, None, system.rigid, frequency_max=self.limit)

    @property
    def sensors(self) -> FloatArray:
        return self.assembly.system().selection(self.dofs)

    @property
    def parts(self) -> tuple[PartMatrices, ...]:
        return part_matrices(self.assembly, coefficients_of(self.structure), self.parameters)

    def changes(self) -> list[tuple[FloatArray, FloatArray]]:
        """Return dM and dK of every coefficient, (n, n), put together element by element."""
        assembly, base = self.assembly, coefficients_of(self.structure)
        nothing = np.zeros((len(self.structure.dofs),) * 2)
        out = []
        for macro, row in zip(self.parameters.macros, self.parameters.groups(self.structure), strict=True):
            mass, axial, bending = (
                assembly.matrix((row * part)[:, None, None] * matrices).toarray()
                for part, matrices in (
                    (base.mass, assembly.mass),
                    (base.axial, assembly.axial),
                    (base.bending, assembly.bending),
                )
            )
            stiff = {Part.STIFFNESS: axial + bending, Part.AXIAL: axial, Part.BENDING: bending}
            out.append((mass, nothing) if macro.part is Part.MASS else (nothing, stiff[macro.part]))
        return out


@dataclass(frozen=True, eq=False)
class Stepped:
    """What the complex step makes of modes that move together."""

    eigenvalues: FloatArray  # (k, k, n_params)
    shapes: FloatArray  # (n_dof, k, n_params)


def complex_step(case: Case, shapes: FloatArray, squares: FloatArray) -> Stepped:
    """Solve K Phi = M Phi Lambda, Phi0^T M0 Phi = 1, with one coefficient after the other off by i STEP.

    Newton's method in complex arithmetic, from the real modes (n, k); at the end Phi^T M Phi = 1 again.
    """
    system, k = case.assembly.system(), len(squares)
    stiffness, mass = system.stiffness.toarray(), system.mass.toarray()
    border = mass @ shapes
    found = []
    for d_mass, d_stiffness in case.changes():
        m, s = mass + 1j * STEP * d_mass, stiffness + 1j * STEP * d_stiffness
        phi, full = shapes.astype(complex), np.diag(squares).astype(complex)
        for _ in range(4):
            phi, full = _newton(s, m, phi, full, border)
        # (Phi^T M Phi)^(-1/2) and its inverse to the first order, all there is of a step this small
        off = 1j * (phi.T @ m @ phi).imag / 2
        phi, full = phi - phi @ off, full + off @ full - full @ off
        found.append((full.imag / STEP, case.sensors.T @ phi.imag / STEP))
    matrices, moved = zip(*found, strict=True)
    assert matrices[0].shape == (k, k)
    return Stepped(np.moveaxis(np.array(matrices), 0, -1), np.moveaxis(np.array(moved), 0, -1))


def _newton(
    stiffness: ComplexArray, mass: ComplexArray, phi: ComplexArray, full: ComplexArray, border: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return one step, mode by mode of a Lambda that is diagonal but for its last correction."""
    n, k = phi.shape
    missed = stiffness @ phi - mass @ phi @ full
    held = border.T @ phi - np.eye(k)
    new_phi, new_full = phi.copy(), full.copy()
    for r in range(k):
        system = np.block(
            [[stiffness - full[r, r] * mass, -mass @ phi], [border.T.astype(complex), np.zeros((k, k))]]
        )
        size = 1 / np.sqrt(np.abs(np.diag(stiffness)))  # rows and columns of one size, translations or turns
        scale = np.concatenate([size, np.full(k, np.abs(full[r, r]))])
        right = -np.concatenate([missed[:, r], held[:, r]])
        rows = np.concatenate([size, np.ones(k)])
        step = scale * np.linalg.solve(rows[:, None] * system * scale, rows * right)
        new_phi[:, r] += step[:n]
        new_full[:, r] += step[n:]
    return new_phi, new_full


def near(ours: FloatArray | ComplexArray, exact: FloatArray, tolerance: float = EXACT) -> None:
    np.testing.assert_allclose(ours, exact, rtol=0, atol=tolerance * np.abs(exact).max())


def plate_of(length: float, width: float, n_elements: tuple[int, int]) -> Structure:
    steel = Material(2.09e11, 7800.0)
    return plate(length=length, width=width, thickness=0.004, n_elements=n_elements, material=steel)


def square(width: float = 0.4) -> Case:
    """Return a plate two of whose modes are at one frequency, or nearly: 108 DoFs, all modes known."""
    return Case(plate_of(0.4, width, (5, 5)), parameterise([(1, 2), (7, 13)]), PLATE_DOFS)


BAY_DOFS = (Dof(1, "X"), Dof(8, "Y", -1), Dof(26, "X"))
BEAM_DOFS = (Dof(1, "Y"), Dof(9, "Y"), Dof(21, "RZ"))
PLATE_DOFS = (Dof(1, "Z"), Dof(9, "Z", -1), Dof(20, "RX"))
CASES = {
    "bay by parts": Case(
        STRUCTURES["bay"](), parameterise([(5,), (25, 26), (31,)], ("mass", "axial", "bending")), BAY_DOFS
    ),
    "bay by macro elements": Case(STRUCTURES["bay"](), parameterise([(1, 2, 3), (12, 13)]), BAY_DOFS),
    "free beam": Case(STRUCTURES["chapter-5-beam"](), parameterise([(1, 2), (11,)]), BEAM_DOFS),
    "cantilever": Case(STRUCTURES["cantilever"](), parameterise([(1, 2), (11,)]), BEAM_DOFS[1:]),
    "small plate": Case(plate_of(0.4, 0.3, (5, 5)), parameterise([(1, 2), (7,), (13, 25)]), PLATE_DOFS),
}
# From here on not all modes are worked out.
LARGE = {
    "plate": Case(
        STRUCTURES["plate"](), parameterise([(1, 2, 14), (40,)]), (*PLATE_DOFS, Dof(60, "Z")), 600.0
    ),
    "long cantilever": Case(
        long_cantilever(),
        parameterise([tuple(range(1, 14)), tuple(range(60, 80))]),
        (Dof(40, "Y"), Dof(131, "Y")),
        400.0,
    ),
}


def stepped(case: Case, basis: ModalBasis, modes: IntArray) -> Stepped:
    """Return the complex step of single modes."""
    squares, shapes = basis.eigenvalues.real, basis.shapes.real
    each = [complex_step(case, shapes[:, [r]], squares[[r]]) for r in modes]
    return Stepped(
        np.concatenate([one.eigenvalues[0] for one in each]),
        np.concatenate([one.shapes for one in each], axis=1),
    )


@pytest.mark.parametrize("name", CASES)
def test_derivatives_from_all_modes_are_exact(name: str) -> None:
    case = CASES[name]
    basis = case.basis
    modes = basis.n_rigid_body + np.array([0, 1, 4])
    ours = derivatives(basis, modes, case.sensors, case.parts)
    exact = stepped(case, basis, modes)
    near(ours.eigenvalues, exact.eigenvalues)
    near(ours.shapes, exact.shapes)
    assert not ours.truncation_bound.any()


def test_coefficients_that_members_carry_scale_their_derivatives() -> None:
    case = CASES["cantilever"]
    members = case.structure.members
    heavier = replace(members[4], mass_factor=2.0)
    changed = replace(
        case,
        structure=replace(case.structure, members=(*members[:4], heavier, *members[5:])),
        parameters=parameterise([(5,)], ("mass",)),
    )
    basis, modes = changed.basis, np.array([0, 1])
    ours = derivatives(basis, modes, changed.sensors, changed.parts)
    near(ours.eigenvalues, stepped(changed, basis, modes).eigenvalues)


@pytest.mark.parametrize("name", LARGE)
def test_derivatives_from_some_modes_are_exact_where_asked_for(name: str) -> None:
    case = LARGE[name]
    assert len(case.structure.dofs) >= EIGENSOLUTION.dense_dofs
    basis = case.basis
    modes = basis.n_rigid_body + np.array([0, 1, 4])
    ours = derivatives(basis, modes, case.sensors, case.parts, higher_modes=HigherModes.EXACT)
    exact = stepped(case, basis, modes)
    near(ours.eigenvalues, exact.eigenvalues)
    near(ours.shapes, exact.shapes)
    assert not ours.truncation_bound.any()


def loads(case: Case, shapes: FloatArray, squares: FloatArray) -> FloatArray:
    """Return (dK - lambda dM) phi of every coefficient, (n_params, n, n_modes)."""
    return np.array([dk @ shapes - dm @ shapes * squares for dm, dk in case.changes()])


@pytest.mark.parametrize("above", [HigherModes.OMITTED, HigherModes.STATIC])
@pytest.mark.parametrize("name", LARGE)
def test_derivatives_from_some_modes_are_off_by_no_more_than_stated(name: str, above: HigherModes) -> None:
    case = LARGE[name]
    basis = case.basis
    modes = basis.n_rigid_body + np.array([0, 1, 4])
    ours = derivatives(basis, modes, case.sensors, case.parts, higher_modes=above)
    exact = stepped(case, basis, modes)
    near(ours.eigenvalues, exact.eigenvalues)
    system, remainder = case.assembly.system(), basis.remainder
    assert remainder is not None
    squares, shapes = eigh(system.stiffness.toarray(), system.mass.toarray())
    count = len(basis.eigenvalues)
    softness = shapes[:, count:] / np.sqrt(squares[count:] + remainder.shift)  # G = softness softness^T
    own = basis.eigenvalues.real[modes]
    pushed = softness.T @ loads(case, basis.shapes[:, modes].real, own)  # (n_params, m, n_modes)
    most = np.linalg.norm(case.sensors.T @ softness, axis=1)[:, None, None] * np.linalg.norm(pushed, axis=1).T
    off = np.abs(ours.shapes - exact.shapes)
    stated = ours.truncation_bound[:, None] * most
    assert (off <= stated * (1 + EXACT) + EXACT * np.abs(exact.shapes).max()).all()
    # and the statement is of the right size: off by more than a thousandth of it somewhere
    assert (off > 1e-3 * stated).any()
    first = off[:, 0].max() / np.abs(exact.shapes[:, 0]).max()
    # the lowest modes are far below those that count statically: 1 % at most of what these add
    assert first < (1e-3 if above is HigherModes.STATIC else 1.0)


def paired(case: Case) -> tuple[ModalBasis, IntArray]:
    """Return modes of a square plate, and the two of them that are nearest to one another in frequency."""
    basis = case.basis
    gaps = np.diff(basis.eigenvalues.real[basis.n_rigid_body :])
    first = basis.n_rigid_body + int(np.argmin(gaps[:6]))
    return basis, np.array([first, first + 1])


@pytest.mark.parametrize(
    ("width", "apart"), [(0.4, 1e-9), (0.4 + 1e-8, 1e-7), (0.4001, 1e-3)], ids=["repeated", "nearly", "close"]
)
def test_modes_at_one_frequency_or_nearly_move_as_a_subspace(width: float, apart: float) -> None:
    case = square(width)
    basis, modes = paired(case)
    squares = basis.eigenvalues.real[modes]
    assert squares[1] - squares[0] < apart * squares[1]
    ours = subspace_derivatives(basis, modes, case.sensors, case.parts)
    exact = complex_step(case, basis.shapes[:, modes].real, squares)
    near(ours.eigenvalues, exact.eigenvalues)
    near(ours.shapes, exact.shapes)
    near(ours.eigenvalues, ours.eigenvalues.swapaxes(0, 1).real)


@pytest.mark.parametrize("width", [0.40001, 0.4001, 0.404])
def test_modes_close_to_one_another_have_exact_derivatives_each(width: float) -> None:
    case = square(width)
    basis, modes = paired(case)
    squares = basis.eigenvalues.real[modes]
    assert 1e-5 < squares[1] / squares[0] - 1 < 2e-2
    ours = derivatives(basis, modes, case.sensors, case.parts)
    exact = stepped(case, basis, modes)
    near(ours.eigenvalues, exact.eigenvalues)
    near(ours.shapes, exact.shapes)


def test_close_modes_of_a_large_model_move_as_a_subspace_of_some_modes() -> None:
    structure = plate_of(0.4, 0.4, (9, 9))
    assert len(structure.dofs) >= EIGENSOLUTION.dense_dofs
    case = Case(structure, parameterise([(1, 2), (30,)]), PLATE_DOFS, 800.0)
    basis, modes = paired(case)
    squares = basis.eigenvalues.real[modes]
    ours = subspace_derivatives(basis, modes, case.sensors, case.parts, higher_modes=HigherModes.EXACT)
    exact = complex_step(case, basis.shapes[:, modes].real, squares)
    near(ours.eigenvalues, exact.eigenvalues)
    near(ours.shapes, exact.shapes)


def test_repeated_eigenvalues_part_as_those_of_their_block() -> None:
    case = square()
    basis, modes = paired(case)
    block = subspace_derivatives(basis, modes, case.sensors, case.parts).eigenvalues
    system, step = case.assembly.system(), 1e-4
    for i, (d_mass, d_stiffness) in enumerate(case.changes()):
        moved = [
            eigh(
                system.stiffness.toarray() + h * d_stiffness,
                system.mass.toarray() + h * d_mass,
                eigvals_only=True,
            )[modes]
            for h in (step, -step)
        ]
        # eigenvalues cross: the larger one ahead is the smaller one behind
        slopes = np.sort((moved[0] - moved[1][::-1]) / (2 * step))
        # of second order in the step are 1e-8 of the eigenvalue, over the step: 1e-4 of the slopes
        np.testing.assert_allclose(slopes, np.linalg.eigvalsh(block[:, :, i]), rtol=1e-3)


def test_modes_at_one_frequency_do_not_turn_in_themselves() -> None:
    case = square()
    basis, modes = paired(case)
    one_by_one = derivatives(basis, modes, case.sensors, case.parts)
    together = subspace_derivatives(basis, modes, case.sensors, case.parts)
    near(one_by_one.shapes, together.shapes.real)
    near(one_by_one.eigenvalues, np.einsum("rrp->rp", together.eigenvalues))


def test_modes_above_damped_ones_are_not_summed_exactly() -> None:
    case = LARGE["plate"]
    basis = case.basis.damped(1e-3 * case.assembly.system().stiffness, None)
    with pytest.raises(InvalidInputError, match="count statically"):
        derivatives(basis, np.array([3]), case.sensors, case.parts, higher_modes=HigherModes.EXACT)
