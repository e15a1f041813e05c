"""Elastic supports: held degrees of freedom on springs, as an attachment to the rigidly held system."""

from collections.abc import Mapping

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.fe.alteration import Alteration, orthonormal_span
from modallab.fe.attachment import MATRIX_NAMES, Attachment
from modallab.fe.member_table import MemberTable
from modallab.fe.structure_settings import ELEMENT

Matrices = dict[str, FloatArray]


def support_springs(
    table: MemberTable, flexibilities: Mapping[Dof, float], alterations: Mapping[int, Alteration], n: int
) -> Attachment:
    """Return held DoFs on springs to the ground as an attachment to a system of `n` DoFs.

    A held DoF s couples to the free ones f by what the members' matrices have there: it adds
    [[dZ_ff, Z_fs], [Z_sf, Z_ss + 1 / flexibility]], with dZ_ff the change by alterations of the same members.
    Coordinates of held DoFs are scaled by the root of the flexibility: a rigid support is a regular limit.

    Parameters
    ----------
    flexibilities
        m/N, of a rotation rad/(N m).
    alterations
        Of members at these DoFs, by number.
    """
    held = [i for i, dof in enumerate(table.held.dofs) if dof in flexibilities]
    members = np.flatnonzero(table.held.members_at(flexibilities))
    rows = table.rows[members]
    free = np.unique(rows[rows >= 0]).tolist()
    matrices = _coupled(table, members.tolist(), free, held, alterations)
    springs = np.arange(len(free), len(free) + len(held))
    matrices["mass"][springs, springs] += table.held.masses[held]
    scale = np.ones(len(matrices["mass"]))
    scale[springs] = np.sqrt([flexibilities[table.held.dofs[i]] for i in held])
    matrices = {name: scale[:, None] * part * scale for name, part in matrices.items()}
    own = matrices["stiffness"][springs, springs]
    matrices["stiffness"][springs, springs] += 1.0
    matrices = _condensed(matrices, springs[own <= ELEMENT.rigid_joint_flexibility])
    return _attachment(matrices, free, n)


def _coupled(
    table: MemberTable,
    members: list[int],
    free: list[int],
    held: list[int],
    alterations: Mapping[int, Alteration],
) -> Matrices:
    """Return the members' matrices at free DoFs, held DoFs and joint rotations.

    Less what the system has of them at free DoFs.
    """
    altered = [table.altered_matrices(e, alterations.get(table.numbers[e], Alteration())) for e in members]
    next_joint = len(free) + len(held)
    size = next_joint + sum(inner for _, inner in altered)
    total = {name: np.zeros((size, size)) for name in MATRIX_NAMES}
    of_free = {row: i for i, row in enumerate(free)}
    of_held = {place: len(free) + i for i, place in enumerate(held)}
    for e, (matrices, inner) in zip(members, altered, strict=True):
        rows, held_rows = table.rows[e].tolist(), table.held.rows[e].tolist()
        places = [of_free.get(r, of_held.get(h, -1)) for r, h in zip(rows, held_rows, strict=True)]
        at = np.array([*places, *range(next_joint, next_joint + inner)])
        next_joint += inner
        present, in_system = np.flatnonzero(at >= 0), np.flatnonzero(table.rows[e] >= 0)
        nominal, _ = table.altered_matrices(e, Alteration())
        for name, matrix in total.items():
            matrix[np.ix_(at[present], at[present])] += matrices[name][np.ix_(present, present)]
            matrix[np.ix_(at[in_system], at[in_system])] -= nominal[name][np.ix_(in_system, in_system)]
    return total


def _condensed(matrices: Matrices, rows: IntArray) -> Matrices:
    """Return matrices without some rows, condensed statically.

    Of a support that is nearly rigid: a coordinate of its own would only add a mode at a very high frequency.
    """
    if not len(rows):
        return matrices
    stiffness = matrices["stiffness"]
    kept = np.setdiff1d(np.arange(len(stiffness)), rows)
    motion = np.zeros((len(stiffness), len(kept)))
    motion[kept, np.arange(len(kept))] = 1.0
    motion[rows] = -np.linalg.solve(stiffness[np.ix_(rows, rows)], stiffness[np.ix_(rows, kept)])
    return {name: motion.T @ part @ motion for name, part in matrices.items()}


def _attachment(matrices: Matrices, free: list[int], n: int) -> Attachment:
    """Return matrices of free DoFs and inner coordinates as an attachment to as few motions as possible."""
    size, inner = len(free), len(matrices["mass"]) - len(free)
    v = orthonormal_span([part[:size] for part in matrices.values()])
    projection = np.zeros((size + inner, v.shape[1] + inner))
    projection[:size, : v.shape[1]] = v
    projection[size:, v.shape[1] :] = np.eye(inner)
    columns = np.zeros((n, v.shape[1]))
    columns[free] = v
    projected = {name: projection.T @ part @ projection for name, part in matrices.items()}
    return Attachment(columns, **projected, inner=inner)
