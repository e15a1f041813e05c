"""The members of an assembled system, and what a change of one adds to it."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array, csc_array

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import InvalidInputError
from modallab.fe.attachment import Attachment
from modallab.fe.damping import Damping, StructuralDamping, ViscousDamping


@dataclass(frozen=True, eq=False)
class MemberTable:
    """The matrices of each member as they stand in a system, and the damping law they follow."""

    numbers: tuple[int, ...]
    ends: tuple[tuple[int, int], ...]  # nodes
    points: FloatArray  # (n_members, 2, 2) m, x and y of each end
    rows: IntArray  # (n_members, 6), -1 where a DoF is held
    mass: FloatArray  # (n_members, 6, 6)
    axial: FloatArray
    bending: FloatArray
    loss_factor: FloatArray  # (n_members,)
    law: Damping

    def position(self, number: int) -> int:
        """Return the place of a member in the table."""
        try:
            return self.numbers.index(number)
        except ValueError:
            raise InvalidInputError(f"there is no member {number}", field="members", value=number) from None

    def change(self, number: int, n: int, *, mass: float, axial: float, bending: float) -> Attachment:
        """Return what a member adds to a system of `n` DoFs when its parts change by these fractions.

        Its damping follows the law of the structure.

        Raises
        ------
        InvalidInputError
            If there is no such member.
        """
        e = self.position(number)
        kept = np.flatnonzero(self.rows[e] >= 0)
        block = np.ix_(kept, kept)
        dm = mass * self.mass[e][block]
        dk = axial * self.axial[e][block] + bending * self.bending[e][block]
        # Rigid motions strain nothing: a change of stiffness alone needs fewer columns than DoFs.
        w, v = np.linalg.eigh(dk if mass == 0 else dm)
        v = v[:, np.abs(w) > 1e-12 * np.abs(w).max(initial=0.0)]
        dm, dk = v.T @ dm @ v, v.T @ dk @ v
        columns = np.zeros((n, v.shape[1]))
        columns[self.rows[e][kept]] = v
        damping, viscous = self.loss_factor[e] * dk, None
        if isinstance(self.law, StructuralDamping):
            damping = damping + self.law.mass_coefficient * dm
        elif isinstance(self.law, ViscousDamping):
            viscous = self.law.mass_coefficient * dm + self.law.stiffness_coefficient * dk
        return Attachment(columns, mass=dm, stiffness=dk, damping=damping, viscous=viscous)

    def scaled(self, *, mass: float, stiffness: float) -> "MemberTable":
        """Return the table with the mass and stiffness of every member multiplied."""
        return replace(
            self, mass=self.mass * mass, axial=self.axial * stiffness, bending=self.bending * stiffness
        )

    def sum(self, parts: FloatArray, n: int) -> csc_array:
        """Return the (n, n) sum of member matrices (n_members, 6, 6)."""
        r = np.broadcast_to(self.rows[:, :, None], parts.shape)
        c = np.broadcast_to(self.rows[:, None, :], parts.shape)
        kept = (r >= 0) & (c >= 0)
        return csc_array(coo_array((parts[kept], (r[kept], c[kept])), shape=(n, n)))
