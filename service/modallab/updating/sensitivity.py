"""Derivatives of eigenvalues and mode shapes with respect to correction coefficients."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.fe.assembly import Assembly, Coefficients
from modallab.fe.modes import ModalBasis
from modallab.updating.parameterisation import Parameterisation, Part

REPEATED = 1e-9  # relative distance of eigenvalues below which their shapes have no derivative


@dataclass(frozen=True, eq=False)
class Derivatives:
    """How modes move with the coefficients."""

    eigenvalues: FloatArray  # (n_modes, n_params) rad^2/s^2
    shapes: FloatArray  # (n_dof, n_modes, n_params) 1/sqrt(kg), at the sensors


@dataclass(frozen=True, eq=False)
class PartMatrices:
    """Element matrices of one part, and the coefficients whose macro elements they add up to.

    Coefficients multiply matrices, so these are the derivatives of M and K wherever the
    coefficients stand.
    """

    part: Part
    matrices: FloatArray  # (n_used, 6, 6) kg or N/m
    rows: IntArray  # (n_used, 6) place in the system, -1 where a DoF is held
    groups: FloatArray  # (n_own, n_used), 1 where an element belongs to a coefficient
    params: IntArray  # (n_own,) place of those coefficients among all


def part_matrices(
    assembly: Assembly, base: Coefficients, parameterisation: Parameterisation
) -> tuple[PartMatrices, ...]:
    """Return the element matrices behind each part, those that no coefficient moves left out."""
    axial = base.axial[:, None, None] * assembly.axial
    bending = base.bending[:, None, None] * assembly.bending
    matrices = {
        Part.MASS: base.mass[:, None, None] * assembly.mass,
        Part.STIFFNESS: axial + bending,
        Part.AXIAL: axial,
        Part.BENDING: bending,
    }
    groups = parameterisation.groups(assembly.structure)
    out = []
    for part in parameterisation.parts:
        params = np.flatnonzero([macro.part is part for macro in parameterisation.macros])
        used = groups[params].any(axis=0)
        rows, own = assembly.rows[used], groups[params][:, used]
        out.append(PartMatrices(part, matrices[part][used], rows, own, params))
    return tuple(out)


def derivatives(
    basis: ModalBasis, modes: IntArray, sensors: FloatArray, parts: tuple[PartMatrices, ...]
) -> Derivatives:
    """Return the derivatives of undamped modes, all elements in one contraction.

    d lambda_r = phi_r^T (dK - lambda_r dM) phi_r; d phi_r is the sum over all modes, rigid-body
    modes among them, of phi_s phi_s^T (dK - lambda_r dM) phi_r / (lambda_r - lambda_s), and
    -1/2 phi_r^T dM phi_r of itself. What modes above the basis add is their static answer.
    1992 thesis, eq. [3.13], [3.17], [A.4], [A.8], [A.10]; Fox and Kapoor (1968); Lim (1987).

    Parameters
    ----------
    basis
        Undamped, mass-normalised.
    modes
        (n_modes,) columns of the basis to differentiate.
    sensors
        (n, n_dof) columns that pick the DoFs where shapes are wanted.
    """
    squares, shapes = basis.eigenvalues.real, basis.shapes.real
    at_sensors = sensors.T @ shapes
    own = squares[modes]
    distance = own - squares[:, None]  # (m, n_modes)
    apart = np.abs(distance) > REPEATED * own
    weight = np.divide(1.0, distance, out=np.zeros_like(distance), where=apart)
    n_params = sum(len(part.params) for part in parts)
    d_squares = np.zeros((len(modes), n_params))
    d_shapes = np.zeros((sensors.shape[1], len(modes), n_params))
    each = np.arange(len(modes))
    above = None
    if basis.remainder is not None:
        above = basis.remainder.static(sensors)
    for part in parts:
        local = _local(part, shapes)
        loads = part.matrices @ local[:, :, modes]  # (n_used, 6, n_modes)
        scale = -own if part.part is Part.MASS else np.ones_like(own)
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


def _local(part: PartMatrices, columns: FloatArray) -> FloatArray:
    """Return columns (n, k) at the DoFs of each element, (n_used, 6, k), 0 where they are held."""
    return np.where(part.rows[:, :, None] >= 0, columns[part.rows], 0.0)
