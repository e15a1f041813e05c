"""Derivatives of eigenvalues and mode shapes with respect to correction coefficients."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.fe.assembly import Assembly, Coefficients
from modallab.fe.modes import ModalBasis
from modallab.updating.parameterisation import Parameterisation, Part

REPEATED = 1e-9  # relative distance of eigenvalues below which their shapes have no derivative


@dataclass(frozen=True, eq=False)
class Derivatives:
    """How modes move with the coefficients; complex where the modes or the coefficients are of damping."""

    eigenvalues: FloatArray | ComplexArray  # (n_modes, n_params) rad^2/s^2
    shapes: FloatArray | ComplexArray  # (n_dof, n_modes, n_params) 1/sqrt(kg), at the sensors


@dataclass(frozen=True, eq=False)
class PartMatrices:
    """Element matrices of one part, and the coefficients whose macro elements they add up to.

    Coefficients multiply matrices, so these are the derivatives of M and K wherever the
    coefficients stand; with damping, of M and K + iD at the coefficients they were made for.
    """

    part: Part
    matrices: FloatArray | ComplexArray  # (n_used, 6, 6) kg or N/m
    rows: IntArray  # (n_used, 6) place in the system, -1 where a DoF is held
    groups: FloatArray  # (n_own, n_used), 1 where an element belongs to a coefficient
    params: IntArray  # (n_own,) place of those coefficients among all


def part_matrices(
    assembly: Assembly,
    base: Coefficients,
    parameterisation: Parameterisation,
    damped: Coefficients | None = None,
) -> tuple[PartMatrices, ...]:
    """Return the element matrices behind each part, those that no coefficient moves left out.

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
            damped.axial[:, None, None] * assembly.axial + damped.bending[:, None, None] * assembly.bending
        )
        matrices[Part.DAMPING] = np.asarray(1j * stiffness, complex)
    groups = parameterisation.groups(assembly.structure)
    out = []
    for part in parameterisation.parts:
        params = np.flatnonzero([macro.part is part for macro in parameterisation.macros])
        used = groups[params].any(axis=0)
        rows, own = assembly.rows[used], groups[params][:, used]
        out.append(PartMatrices(part, matrices[part][used], rows, own, params))
    return tuple(out)


def derivatives(
    basis: ModalBasis,
    modes: IntArray,
    sensors: FloatArray,
    parts: tuple[PartMatrices, ...],
    mass_loss: float = 0.0,
) -> Derivatives:
    """Return the derivatives of modes, all elements in one contraction.

    d lambda_r = phi_r^T (dK - lambda_r dM) phi_r; d phi_r is the sum over all modes, rigid-body
    modes among them, of phi_s phi_s^T (dK - lambda_r dM) phi_r / (lambda_r - lambda_s), and
    -1/2 phi_r^T dM phi_r of itself. What modes above the basis add is their static answer. The same
    holds of hysteretically damped modes, with K + iD for K and the plain transpose.
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
    """
    damped = bool(basis.eigenvalues.imag.any())
    squares, shapes = basis.eigenvalues if damped else basis.eigenvalues.real, basis.shapes
    at_sensors = sensors.T @ shapes
    own = squares[modes]
    distance = own - squares[:, None]  # (m, n_modes)
    apart = np.abs(distance) > REPEATED * np.abs(own)
    weight = np.divide(1.0, distance, out=np.zeros_like(distance), where=apart)
    n_params = sum(len(part.params) for part in parts)
    dtype = np.result_type(squares, shapes, *(part.matrices for part in parts))
    d_squares = np.zeros((len(modes), n_params), dtype)
    d_shapes = np.zeros((sensors.shape[1], len(modes), n_params), dtype)
    each = np.arange(len(modes))
    inertia = 1j * mass_loss - own if mass_loss and damped else -own
    above = None
    if basis.remainder is not None:
        above = basis.remainder.static(sensors)
    for part in parts:
        local = _local(part, shapes)
        loads = part.matrices @ local[:, :, modes]  # (n_used, 6, n_modes)
        scale = inertia if part.part is Part.MASS else np.ones_like(own)
        modal = np.tensordot(part.groups, local.swapaxes(1, 2) @ loads, 1)  # (n_own, m, n_modes)
        d_squares[:, part.params] = (scale * modal[:, modes, each]).T
        share = scale * modal * weight
        if part.part is Part.MASS:
            share[:, modes, each] = -0.5 * modal[:, modes, each]
        moved = at_sensors @ share  # (n_own, n_dof, n_modes)
        if above is not None:
            moved -= scale * np.tensordot(part.groups, _local(part, above).swapaxes(1, 2) @ loads, 1)
        d_shapes[:, :, part.params] = moved.transpose(1, 2, 0)
    return Derivatives(d_squares, d_shapes)


def _local(part: PartMatrices, columns: FloatArray | ComplexArray) -> FloatArray | ComplexArray:
    """Return columns (n, k) at the DoFs of each element, (n_used, 6, k), 0 where they are held."""
    return np.where(part.rows[:, :, None] >= 0, columns[part.rows], 0.0)
