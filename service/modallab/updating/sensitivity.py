"""Derivatives of eigenvalues and mode shapes with respect to correction coefficients."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.fe.assembly import Assembly, Coefficients
from modallab.fe.modes import ModalBasis
from modallab.updating.parameterisation import Parameterisation, Part
from modallab.updating.truncation import HigherModes, higher_modes_at, truncation_bound


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Derivatives of modes; complex where modes or coefficients are damped."""

    eigenvalues: FloatArray | ComplexArray
    """rad^2/s^2, (n_modes, n_params)."""
    shapes: FloatArray | ComplexArray
    """1/sqrt(kg); at the sensors (n_dof, n_modes, n_params)."""
    truncation_bound: FloatArray
    """(n_modes,) error bound of shapes, over the static contribution of higher modes: with their static
    flexibility G at a sensor s and under the load f of a coefficient, sqrt(s^T G s f^T G f).
    """


@dataclass(frozen=True, eq=False)
class SubspaceDerivatives:
    """Derivatives of modes as one subspace, in a basis that does not rotate within it.

    K Phi = M Phi Lambda with a full Lambda is smooth where eigenvalues coincide, single modes are not.
    """

    eigenvalues: FloatArray | ComplexArray
    """rad^2/s^2, of Lambda (n_modes, n_modes, n_params), symmetric."""
    shapes: FloatArray | ComplexArray
    """1/sqrt(kg); at the sensors (n_dof, n_modes, n_params)."""
    truncation_bound: FloatArray
    """(n_modes,) as in `Derivatives`."""


@dataclass(frozen=True, eq=False)
class PartMatrices:
    """Element matrices of one part, grouped by coefficient.

    Coefficients multiply matrices, so that these are the derivatives of M and K at any coefficients; with
    damping, of M and K + iD at the given coefficients. Matrices of properties, such as a thickness, are
    derivatives at the given coefficients: of the mass, under the part `MASS`, and of the stiffness. A
    coefficient that changes both is in two.
    """

    part: Part  # mass, or a part of the stiffness
    matrices: FloatArray | ComplexArray  # (n_used, 6, 6) kg or N/m
    rows: IntArray  # (n_used, 6) index in the system, -1 for a supported DoF
    starts: IntArray  # (n_own + 1,) offsets of the elements of each coefficient
    params: IntArray  # (n_own,) index of these coefficients among all
    lossless: bool = False  # nodal masses and springs: no damping law acts on them

    def between(
        self, left_vectors: FloatArray | ComplexArray, right_vectors: FloatArray | ComplexArray
    ) -> FloatArray | ComplexArray:
        """Return left^T A right of every coefficient's matrix A, (n_own, k, m), for (n, k) and (n, m)."""
        loads = self.matrices @ _local(self.rows, right_vectors)
        local_left = _local(self.rows, left_vectors)
        if len(self.params) == len(self.rows):
            return local_left.swapaxes(1, 2) @ loads
        # stacked elements of a coefficient: the matrix product also adds them up
        k, m = left_vectors.shape[1], right_vectors.shape[1]
        kind = complex if np.iscomplexobj(local_left) or np.iscomplexobj(loads) else float
        out: FloatArray | ComplexArray = np.empty((len(self.params), k, m), kind)
        for i, (start, stop) in enumerate(pairwise(self.starts)):
            np.matmul(local_left[start:stop].reshape(-1, k).T, loads[start:stop].reshape(-1, m), out=out[i])
        return out


def part_matrices(
    assembly: Assembly,
    base: Coefficients,
    parameterisation: Parameterisation,
    damped: Coefficients | None = None,
) -> tuple[PartMatrices, ...]:
    """Return the element matrices of each part, without elements that have no coefficient.

    Matrices of properties come from `CorrectedModel.parts`.

    Parameters
    ----------
    base
        Factors of the structure's members.
    damped
        Coefficients of a damped model: its stiffness has the factor 1 + i eta, and its loss factors multiply
        the corrected stiffness. 1992 thesis, eq. [6.1], [6.16].
    """
    axial_factor: FloatArray | ComplexArray = base.axial
    bending_factor: FloatArray | ComplexArray = base.bending
    if damped is not None:
        complex_factor = np.asarray(1 + 1j * damped.loss_factor, complex)
        axial_factor, bending_factor = complex_factor * base.axial, complex_factor * base.bending
    axial = axial_factor[:, None, None] * assembly.axial
    bending = bending_factor[:, None, None] * assembly.bending
    matrices: dict[Part, FloatArray | ComplexArray] = {
        Part.MASS: base.mass[:, None, None] * assembly.mass,
        Part.STIFFNESS: axial + bending,
        Part.AXIAL: axial,
        Part.BENDING: bending,
    }
    if damped is not None:
        stiffness = (
            damped.axial[:, None, None] * assembly.axial
            + damped.bending[:, None, None] * assembly.bending
            + assembly.springs
        )
        matrices[Part.DAMPING] = np.asarray(1j * stiffness, complex)
    groups = parameterisation.groups(assembly.structure)
    out = []
    for part in parameterisation.parts:
        if not part.is_property and not part.is_nodal:
            used, starts, params = elements_of_part(parameterisation, part, groups)
            out.append(PartMatrices(part, matrices[part][used], assembly.rows[used], starts, params))
    return tuple(out)


def elements_of_part(
    parameterisation: Parameterisation, part: Part, groups: FloatArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Return indices of the members of a part's coefficients, their offsets and their coefficients.

    Parameters
    ----------
    groups
        (n_macros, n_members), from `Parameterisation.groups`.
    """
    params = np.flatnonzero([macro.part is part for macro in parameterisation.macros])
    members = [np.flatnonzero(row) for row in groups[params]]
    return np.concatenate(members), np.cumsum([0, *map(len, members)]), params


def derivatives(
    basis: ModalBasis,
    modes: IntArray,
    sensors: FloatArray,
    parts: tuple[PartMatrices, ...],
    mass_loss: float = 0.0,
    *,
    higher_modes: HigherModes = HigherModes.STATIC,
    planes: Sequence[IntArray] = (),
    rotation: FloatArray | None = None,
) -> Derivatives:
    """Return the derivatives of modes with respect to all coefficients in one contraction.

    d lambda_r = phi_r^T (dK - lambda_r dM) phi_r; d phi_r is the sum over all modes, rigid-body modes
    included, of phi_s phi_s^T (dK - lambda_r dM) phi_r / (lambda_r - lambda_s), and -1/2 phi_r^T dM phi_r of
    itself. Modes above the basis are added at the sensors by one or a few solves for each of these,
    independent of the number of coefficients. Hysteretically damped modes take K + iD for K and the plain
    transpose. Repeated modes are taken as a subspace: see `subspace_derivatives`.
    1992 thesis, eq. [3.13], [3.17], [6.14] to [6.16], [A.4], [A.8], [A.10]; Fox and Kapoor (1968); Lim
    (1987).

    Parameters
    ----------
    basis
        Mass-normalised.
    modes
        (n_modes,) columns of the basis to differentiate.
    sensors
        (n, n_dof) columns that select the measured DoFs.
    mass_loss
        a of D = a M + ..., rad^2/s^2: damping proportional to mass.
    higher_modes
        Treatment of modes above the basis.
    planes, rotation
        Groups of indices into `modes` that form one subspace each, and the orthogonal rotation R
        (n_modes, n_modes) to the basis in use: modes of a group do not rotate towards one another, and
        eigenvalues are the diagonal of R^T Lambda R.

    Raises
    ------
    InvalidInputError
        If higher modes of a damped basis are to be treated exactly.
    """
    squares = basis.eigenvalues
    eigenvalues = squares[modes]
    is_same_subspace = np.abs(eigenvalues - squares[:, None]) <= COMPARISON_ROUNDING * np.abs(eigenvalues)
    for plane in planes:
        is_same_subspace[np.ix_(modes[plane], plane)] = True
    subspace = _subspace_derivatives(basis, modes, sensors, parts, is_same_subspace, mass_loss, higher_modes)
    if rotation is None:
        diagonal = np.arange(len(modes))
        return Derivatives(
            subspace.eigenvalues[diagonal, diagonal], subspace.shapes, subspace.truncation_bound
        )
    rotated = np.einsum("ijp,ik,jk->kp", subspace.eigenvalues, rotation, rotation, optimize=True)
    return Derivatives(rotated, rotation.T @ subspace.shapes, subspace.truncation_bound)


def subspace_derivatives(
    basis: ModalBasis,
    modes: IntArray,
    sensors: FloatArray,
    parts: tuple[PartMatrices, ...],
    mass_loss: float = 0.0,
    *,
    higher_modes: HigherModes = HigherModes.STATIC,
) -> SubspaceDerivatives:
    """Return the derivatives of equal or close modes, as one subspace.

    Modes outside contribute as in `derivatives`; inside, Phi^T M dPhi = -1/2 Phi^T dM Phi, and dLambda =
    Phi^T dK Phi - 1/2 (Phi^T dM Phi Lambda + Lambda Phi^T dM Phi). Where the modes are repeated, the
    eigenvalues of dLambda are the derivatives of theirs, along any one change of the coefficients.
    Mills-Curran (1988), AIAA Journal 26, 867-871.

    Parameters
    ----------
    basis, sensors, mass_loss, higher_modes
        As of `derivatives`.
    modes
        (n_modes,) columns of the basis that span the subspace.
    """
    is_same_subspace = np.zeros((len(basis.eigenvalues), len(modes)), bool)
    is_same_subspace[modes] = True
    return _subspace_derivatives(basis, modes, sensors, parts, is_same_subspace, mass_loss, higher_modes)


def _subspace_derivatives(
    basis: ModalBasis,
    modes: IntArray,
    sensors: FloatArray,
    parts: tuple[PartMatrices, ...],
    is_same_subspace: BoolArray,
    mass_loss: float,
    higher_modes: HigherModes,
) -> SubspaceDerivatives:
    """Return derivatives of modes without rotation within the subspaces of the mask (m, n_modes)."""
    damped = bool(basis.eigenvalues.imag.any())
    squares = basis.eigenvalues if damped else basis.eigenvalues.real
    eigenvalues = squares[modes]
    weight = _inverse_differences(squares, eigenvalues, is_same_subspace)
    n_params, n_modes = 1 + max(int(part.params.max()) for part in parts), len(squares)
    dtype = np.result_type(squares, basis.shapes, *(part.matrices for part in parts))
    d_squares = np.zeros((n_params, len(modes), len(modes)), dtype)
    d_shapes = np.zeros((n_params, sensors.shape[1], len(modes)), dtype)
    at_sensors, mode_shapes = sensors.T @ basis.shapes, basis.shapes[:, modes]
    higher_mode_terms = higher_modes_at(basis, modes, sensors, higher_modes)
    columns, factor = next(higher_mode_terms, (np.zeros((len(sensors), 0)), np.ones(len(modes))))
    left_vectors: FloatArray | ComplexArray = np.concatenate([basis.shapes, columns], axis=1)
    for part in parts:
        is_mass, scale = part.part is Part.MASS, _scale(part, eigenvalues, mass_loss if damped else 0.0)
        sums = part.between(left_vectors, mode_shapes)  # (n_own, m + n_dof, n_modes)
        modal = sums[:, :n_modes]
        mean_scale = (scale + scale[:, None]) / 2
        d_squares[part.params] += mean_scale * modal[:, modes]
        share = modal * (scale * weight - 0.5 * is_same_subspace if is_mass else weight)
        d_shapes[part.params] += at_sensors @ share
        if columns.size:
            d_shapes[part.params] -= scale * factor * sums[:, n_modes:]
    for columns, factor in higher_mode_terms:
        for part in parts:
            scale = _scale(part, eigenvalues, mass_loss if damped else 0.0)
            d_shapes[part.params] -= scale * factor * part.between(columns, mode_shapes)
    return SubspaceDerivatives(
        d_squares.transpose(1, 2, 0),
        d_shapes.transpose(1, 2, 0),
        truncation_bound(basis, modes, higher_modes),
    )


def _inverse_differences(
    squares: FloatArray | ComplexArray, eigenvalues: FloatArray | ComplexArray, is_same_subspace: BoolArray
) -> FloatArray | ComplexArray:
    """Return one over the differences of eigenvalues, (m, n_modes), 0 within a subspace."""
    return np.divide(
        1.0,
        eigenvalues - squares[:, None],
        out=np.zeros(is_same_subspace.shape, squares.dtype),
        where=~is_same_subspace,
    )


def _scale(
    part: PartMatrices, squares: FloatArray | ComplexArray, mass_loss: float
) -> FloatArray | ComplexArray:
    """Return the factor of a part's matrices in dK - lambda dM, with mass-proportional damping (n_modes,)."""
    if part.part is not Part.MASS:
        return np.ones(len(squares))
    return -squares if part.lossless or not mass_loss else np.asarray(1j * mass_loss - squares)


def _local(rows: IntArray, columns: FloatArray | ComplexArray) -> FloatArray | ComplexArray:
    """Return columns (n, k) at the DoFs of each element, (n_used, w, k), 0 for supported DoFs."""
    zero_row = np.zeros((1, columns.shape[1]), columns.dtype)
    return np.asarray(np.concatenate([columns, zero_row])[rows])
