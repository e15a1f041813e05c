"""Derivatives of eigenvalues and mode shapes with respect to correction coefficients."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.fe.assembly import Assembly, Coefficients
from modallab.fe.modes import ModalBasis
from modallab.updating.parameterisation import Parameterisation, Part
from modallab.updating.truncation import HigherModes, higher_modes_at, left_out

REPEATED = 1e-9  # relative distance of eigenvalues below which their shapes have no derivative


@dataclass(frozen=True, eq=False)
class Derivatives:
    """How modes move with the coefficients; complex where the modes or the coefficients are of damping."""

    eigenvalues: FloatArray | ComplexArray  # (n_modes, n_params) rad^2/s^2
    shapes: FloatArray | ComplexArray  # (n_dof, n_modes, n_params) 1/sqrt(kg), at the sensors
    # (n_modes,) by which shapes may be off, as a share of what modes above the basis can add: their static
    # flexibility G at a sensor s and under the load f of a coefficient, sqrt(s^T G s f^T G f)
    left_out: FloatArray


@dataclass(frozen=True, eq=False)
class SubspaceDerivatives:
    """How modes move together, in a basis of theirs that does not turn in itself.

    K Phi = M Phi Lambda with a full Lambda: smooth where eigenvalues meet and single modes are not.
    """

    eigenvalues: FloatArray | ComplexArray  # (n_modes, n_modes, n_params) of Lambda, rad^2/s^2, symmetric
    shapes: FloatArray | ComplexArray  # (n_dof, n_modes, n_params) 1/sqrt(kg), at the sensors
    left_out: FloatArray  # (n_modes,) as of `Derivatives`


@dataclass(frozen=True, eq=False)
class PartMatrices:
    """Element matrices of one part, coefficient by coefficient.

    Coefficients multiply matrices, so these are the derivatives of M and K wherever the
    coefficients stand; with damping, of M and K + iD at the coefficients they were made for. Those of
    properties, as a thickness, are derivatives there too: of the mass, under the part `MASS`, and of the
    stiffness. A coefficient that moves both is in two.
    """

    part: Part  # whose matrices these are; mass or some of the stiffness
    matrices: FloatArray | ComplexArray  # (n_used, 6, 6) kg or N/m
    rows: IntArray  # (n_used, 6) place in the system, -1 where a DoF is held
    starts: IntArray  # (n_own + 1,) where the elements of each coefficient begin, and where the last end
    params: IntArray  # (n_own,) place of those coefficients among all
    lossless: bool = False  # what nodes carry: no law of damping acts on it

    def between(
        self, left: FloatArray | ComplexArray, right: FloatArray | ComplexArray
    ) -> FloatArray | ComplexArray:
        """Return left^T A right of every coefficient's matrix A, (n_own, k, m), for (n, k) and (n, m)."""
        loads = self.matrices @ _local(self.rows, right)
        facing = _local(self.rows, left)
        if len(self.params) == len(self.rows):
            return facing.swapaxes(1, 2) @ loads
        # Elements of a coefficient one below the other: a product of matrices adds them up as well.
        k, m = left.shape[1], right.shape[1]
        kind = complex if np.iscomplexobj(facing) or np.iscomplexobj(loads) else float
        out: FloatArray | ComplexArray = np.empty((len(self.params), k, m), kind)
        for i, (start, stop) in enumerate(pairwise(self.starts)):
            np.matmul(facing[start:stop].reshape(-1, k).T, loads[start:stop].reshape(-1, m), out=out[i])
        return out


def part_matrices(
    assembly: Assembly,
    base: Coefficients,
    parameterisation: Parameterisation,
    damped: Coefficients | None = None,
) -> tuple[PartMatrices, ...]:
    """Return the element matrices behind each part, those that no coefficient moves left out.

    Those of properties are in `property_matrices`.

    Parameters
    ----------
    base
        What the structure's members carry.
    damped
        Where a damped model stands: its stiffness has 1 + i eta as a factor, and its loss factors
        the stiffness corrected so far. 1992 thesis, eq. [6.1], [6.16].
    """
    stretch: FloatArray | ComplexArray = base.axial
    bend: FloatArray | ComplexArray = base.bending
    if damped is not None:
        lost = np.asarray(1 + 1j * damped.loss_factor, complex)
        stretch, bend = lost * base.axial, lost * base.bending
    axial = stretch[:, None, None] * assembly.axial
    bending = bend[:, None, None] * assembly.bending
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
        if not part.physical and not part.at_node:
            used, starts, params = moved_by(parameterisation, part, groups)
            out.append(PartMatrices(part, matrices[part][used], assembly.rows[used], starts, params))
    return tuple(out)


def moved_by(
    parameterisation: Parameterisation, part: Part, groups: FloatArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Return places of the members of a part's coefficients, where each one's begin, and which these are.

    Parameters
    ----------
    groups
        (n_macros, n_members), from `Parameterisation.groups`.
    """
    params = np.flatnonzero([macro.part is part for macro in parameterisation.macros])
    own = [np.flatnonzero(row) for row in groups[params]]
    return np.concatenate(own), np.cumsum([0, *map(len, own)]), params


def derivatives(
    basis: ModalBasis,
    modes: IntArray,
    sensors: FloatArray,
    parts: tuple[PartMatrices, ...],
    mass_loss: float = 0.0,
    *,
    above: HigherModes = HigherModes.STATIC,
    planes: Sequence[IntArray] = (),
    turn: FloatArray | None = None,
) -> Derivatives:
    """Return the derivatives of modes, all elements in one contraction.

    d lambda_r = phi_r^T (dK - lambda_r dM) phi_r; d phi_r is the sum over all modes, rigid-body
    modes among them, of phi_s phi_s^T (dK - lambda_r dM) phi_r / (lambda_r - lambda_s), and
    -1/2 phi_r^T dM phi_r of itself. What modes above the basis add is found at the sensors: a solve or
    a few for each of these, however many coefficients there are. The same holds of hysteretically
    damped modes, with K + iD for K and the plain transpose. Modes at one frequency are taken as a basis
    of theirs that does not turn in itself: see `subspace_derivatives`.
    1992 thesis, eq. [3.13], [3.17], [6.14] to [6.16], [A.4], [A.8], [A.10]; Fox and Kapoor (1968);
    Lim (1987).

    Parameters
    ----------
    basis
        Mass-normalised.
    modes
        (n_modes,) columns of the basis to differentiate.
    sensors
        (n, n_dof) columns that pick the DoFs where shapes are wanted.
    mass_loss
        a of D = a M + ..., rad^2/s^2: damping that moves with the mass.
    above
        How modes above the basis count.
    planes, turn
        Modes, by place among `modes`, that are looked at as one subspace, in the basis that the orthogonal
        `turn` (n_modes, n_modes) makes of them: none turns towards another, and of Lambda in that basis,
        turn^T Lambda turn, the diagonal counts.

    Raises
    ------
    InvalidInputError
        If they are to count exactly in a basis of damped modes.
    """
    squares = basis.eigenvalues
    own = squares[modes]
    alike = np.abs(own - squares[:, None]) <= REPEATED * np.abs(own)
    for plane in planes:
        alike[np.ix_(modes[plane], plane)] = True
    found = _moved(basis, modes, sensors, parts, alike, mass_loss, above)
    if turn is None:
        each = np.arange(len(modes))
        return Derivatives(found.eigenvalues[each, each], found.shapes, found.left_out)
    turned = np.einsum("ijp,ik,jk->kp", found.eigenvalues, turn, turn, optimize=True)
    return Derivatives(turned, turn.T @ found.shapes, found.left_out)


def subspace_derivatives(
    basis: ModalBasis,
    modes: IntArray,
    sensors: FloatArray,
    parts: tuple[PartMatrices, ...],
    mass_loss: float = 0.0,
    *,
    above: HigherModes = HigherModes.STATIC,
) -> SubspaceDerivatives:
    """Return the derivatives of modes that are the same or nearly so in frequency, as one subspace.

    What the modes outside add is as in `derivatives`; inside, Phi^T M dPhi = -1/2 Phi^T dM Phi, and
    dLambda = Phi^T dK Phi - 1/2 (Phi^T dM Phi Lambda + Lambda Phi^T dM Phi). Where the modes are at one
    frequency the eigenvalues of dLambda are the derivatives of theirs, along any one change of the
    coefficients. Mills-Curran (1988), AIAA Journal 26, 867-871.

    Parameters
    ----------
    basis, sensors, mass_loss, above
        As of `derivatives`.
    modes
        (n_modes,) columns of the basis that span the subspace.
    """
    alike = np.zeros((len(basis.eigenvalues), len(modes)), bool)
    alike[modes] = True
    return _moved(basis, modes, sensors, parts, alike, mass_loss, above)


def _moved(
    basis: ModalBasis,
    modes: IntArray,
    sensors: FloatArray,
    parts: tuple[PartMatrices, ...],
    alike: BoolArray,
    mass_loss: float,
    above: HigherModes,
) -> SubspaceDerivatives:
    """Return derivatives of modes that do not turn towards those `alike`, (m, n_modes) True."""
    damped = bool(basis.eigenvalues.imag.any())
    squares = basis.eigenvalues if damped else basis.eigenvalues.real
    own = squares[modes]
    weight = np.divide(1.0, own - squares[:, None], out=np.zeros(alike.shape, squares.dtype), where=~alike)
    n_params, n_modes = 1 + max(int(part.params.max()) for part in parts), len(squares)
    dtype = np.result_type(squares, basis.shapes, *(part.matrices for part in parts))
    d_squares = np.zeros((n_params, len(modes), len(modes)), dtype)
    d_shapes = np.zeros((n_params, sensors.shape[1], len(modes)), dtype)
    at_sensors, moving = sensors.T @ basis.shapes, basis.shapes[:, modes]
    answers = higher_modes_at(basis, modes, sensors, above)
    columns, factor = next(answers, (np.zeros((len(sensors), 0)), np.ones(len(modes))))
    facing: FloatArray | ComplexArray = np.concatenate([basis.shapes, columns], axis=1)
    for part in parts:
        massive, scale = part.part is Part.MASS, _scale(part, own, mass_loss if damped else 0.0)
        sums = part.between(facing, moving)  # (n_own, m + n_dof, n_modes)
        modal = sums[:, :n_modes]
        both = (scale + scale[:, None]) / 2
        d_squares[part.params] += both * modal[:, modes]
        share = modal * (scale * weight - 0.5 * alike if massive else weight)
        d_shapes[part.params] += at_sensors @ share
        if columns.size:
            d_shapes[part.params] -= scale * factor * sums[:, n_modes:]
    for columns, factor in answers:
        for part in parts:
            scale = _scale(part, own, mass_loss if damped else 0.0)
            d_shapes[part.params] -= scale * factor * part.between(columns, moving)
    return SubspaceDerivatives(
        d_squares.transpose(1, 2, 0), d_shapes.transpose(1, 2, 0), left_out(basis, modes, above)
    )


def _scale(
    part: PartMatrices, squares: FloatArray | ComplexArray, mass_loss: float
) -> FloatArray | ComplexArray:
    """Return by what a part's matrices stand in dK - lambda dM, of damped modes with what mass loses."""
    if part.part is not Part.MASS:
        return np.ones(len(squares))
    return -squares if part.lossless or not mass_loss else np.asarray(1j * mass_loss - squares)


def _local(rows: IntArray, columns: FloatArray | ComplexArray) -> FloatArray | ComplexArray:
    """Return columns (n, k) at the DoFs of each element, (n_used, w, k), 0 where they are held."""
    held = np.zeros((1, columns.shape[1]), columns.dtype)
    return np.asarray(np.concatenate([columns, held])[rows])
