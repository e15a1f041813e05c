"""Member matrices of an assembled system, and attachments for altered members."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array, csc_array

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.alteration import ROTATION_ROWS, Alteration, JointedMember, orthonormal_span, with_joints
from modallab.fe.attachment import MATRIX_NAMES, Attachment
from modallab.fe.damping import Damping
from modallab.fe.held_dofs import HeldDofs
from modallab.fe.losses import Losses
from modallab.fe.shear import Shear


def released_end(
    numbers: Sequence[int], ends: Sequence[Sequence[int]], bars: BoolArray, node: int
) -> tuple[int, int]:
    """Return the number of the bar released by a joint at a node, and the index of its end there.

    The first bar that ends at the node, else the first that starts there: in a row of bars each node has
    a bar of its own.
    """
    bars_at_node = [
        (n, pair) for n, pair, bar in zip(numbers, ends, bars, strict=True) if bar and node in pair
    ]
    incoming = [n for n, pair in bars_at_node if pair[1] == node]
    return (min(incoming), 1) if incoming else (min(n for n, _ in bars_at_node), 0)


@dataclass(frozen=True, eq=False)
class MemberTable:
    """Matrices of each member of a system, and their damping law."""

    numbers: tuple[int, ...]
    ends: tuple[tuple[int, ...], ...]  # nodes; of a bar its two ends
    bars: BoolArray  # (n_members,) straight, with two ends
    points: FloatArray  # (n_members, 2, 2) m, x and y of each end of a bar
    centres: FloatArray  # (n_members, 2 or 3) m, mean of each member's nodes
    rows: IntArray  # (n_members, w), -1 where a DoF is fixed or a member has fewer
    mass: FloatArray  # (n_members, w, w)
    axial: FloatArray
    bending: FloatArray
    losses: Losses
    law: Damping
    shear: Shear
    held: HeldDofs

    def position(self, number: int) -> int:
        """Return the index of a member."""
        try:
            return self.numbers.index(number)
        except ValueError:
            raise InvalidInputError(f"there is no member {number}", field="members", value=number) from None

    def altered(self, number: int, alteration: Alteration, n: int) -> Attachment:
        """Return the attachment of an altered member to a system of `n` DoFs.

        Its damping follows the damping law of the structure.

        Raises
        ------
        InvalidInputError
            If there is no such member.
        """
        e, width = self.position(number), self.rows.shape[1]
        new = self._jointed(e, alteration)
        nominal_padding = (0, new.inner), (0, new.inner)
        dm = new.mass - np.pad(self.mass[e], nominal_padding)
        dk = new.stiffness - np.pad(self.axial[e] + self.bending[e], nominal_padding)
        free = np.flatnonzero(self.rows[e] >= 0)
        lossy = (alteration.loss - 1) * new.stiffness
        # Rigid-body motions cause no strain: most alterations need fewer columns than the member has DoFs.
        v = orthonormal_span(
            [
                part[free][:, columns_of_part]
                for part in (dm, dk, lossy)
                for columns_of_part in (free, slice(width, None))
            ]
        )
        projection = np.zeros((width + new.inner, v.shape[1] + new.inner))
        projection[free, : v.shape[1]] = v
        projection[width:, v.shape[1] :] = np.eye(new.inner)
        columns = np.zeros((n, v.shape[1]))
        columns[self.rows[e][free]] = v
        damping, viscous = self._damped(e, dm, dk + lossy)
        dm, dk, damping, viscous = (projection.T @ part @ projection for part in (dm, dk, damping, viscous))
        return Attachment(columns, dm, dk, damping, viscous, new.inner)

    def altered_matrices(self, e: int, alteration: Alteration) -> tuple[dict[str, FloatArray], int]:
        """Return the matrices (w + k, w + k) of a member, by its index, altered, and k, its joint rotations.

        By name as those of an attachment, joint rotations last; damped by the law of the structure.
        """
        new = self._jointed(e, alteration)
        damping, viscous = self._damped(e, new.mass, alteration.loss * new.stiffness)
        return dict(zip(MATRIX_NAMES, (new.mass, new.stiffness, damping, viscous), strict=True)), new.inner

    def _jointed(self, e: int, alteration: Alteration) -> JointedMember:
        mass, bending = self.mass[e], self.bending[e]
        if alteration.shear:
            (more_mass,), (more_bending,) = self._sheared(
                self.shear.of(e), alteration.shear, alteration.consistent_mass
            )
            mass, bending = mass + more_mass, bending + more_bending
        stiffness = alteration.axial * self.axial[e] + alteration.bending * bending
        return with_joints(alteration.mass * mass, stiffness, alteration.joints, alteration.consistent_mass)

    def _damped(self, e: int, mass: FloatArray, stiffness: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the hysteretic and the viscous damping of a part of a member."""
        losses = self.losses
        return (
            losses.mass[e] * mass + losses.stiffness[e] * stiffness,
            losses.viscous_mass[e] * mass + losses.viscous_stiffness[e] * stiffness,
        )

    @property
    def loaded_held_dofs(self) -> tuple[Dof, ...]:
        """Held DoFs that members couple to free ones."""
        loaded = np.zeros(len(self.held.dofs), bool)
        for e in np.flatnonzero((self.held.rows >= 0).any(axis=1)):
            held, free = self.held.rows[e] >= 0, self.rows[e] >= 0
            part = np.abs(self.mass[e]) + np.abs(self.axial[e]) + np.abs(self.bending[e])
            loaded[self.held.rows[e][held]] |= part[np.ix_(held, free)].any(axis=1)
        return tuple(dof for dof, is_loaded in zip(self.held.dofs, loaded, strict=True) if is_loaded)

    def held_stiffness(self, dof: Dof) -> float:
        """Return the stiffness, N/m (N m/rad of a rotation), of all members at a held DoF."""
        e, row = np.nonzero(self.held.rows == self.held.dofs.index(dof.point))
        return float((self.axial[e, row, row] + self.bending[e, row, row]).sum())

    @property
    def loss_factor(self) -> FloatArray:
        """(n_members,) hysteretic loss factor in proportion to stiffness."""
        return self.losses.stiffness

    @property
    def damping(self) -> tuple[FloatArray, FloatArray]:
        """Hysteretic D_e and viscous C_e, (n_members, w, w) each."""
        return self.losses.matrices(self.mass, self.axial + self.bending)

    def has_bar(self, node: int) -> bool:
        """Return whether a bar ends at a node."""
        return any(bar and node in pair for pair, bar in zip(self.ends, self.bars, strict=True))

    def bar_lengths(self, node: int) -> FloatArray:
        """Return the lengths (n_bars,), m, of the bars that end at a node."""
        joined = [bar and node in pair for pair, bar in zip(self.ends, self.bars, strict=True)]
        ends = self.points[np.array(joined, bool)]
        return np.asarray(np.hypot(*(ends[:, 1] - ends[:, 0]).T))

    def end_at(self, node: int, member: int | None = None) -> tuple[int, int]:
        """Return the number of the member released by a joint at a node, and its end; see `released_end`.

        Parameters
        ----------
        member
            Number of the member; None: the first one that ends at the node.

        Raises
        ------
        InvalidInputError
            If fewer than two members meet at the node, or the member is none of them.
        """
        if node not in self.joints:
            raise InvalidInputError(
                f"no two members meet at node {node}",
                field="at",
                value=node,
                allowed=list(self.joints),
            )
        if member is None:
            return released_end(self.numbers, self.ends, self.bars, node)
        if member not in (meeting := self.bars_at(node)):
            raise InvalidInputError(
                f"member {member} does not end at node {node}",
                field="member",
                value=member,
                allowed=list(meeting),
            )
        return member, self.ends[self.position(member)].index(node)

    def bars_at(self, node: int) -> tuple[int, ...]:
        """Return the numbers of the bars that end at a node, first that of a joint without a member."""
        at_node = (
            n for n, pair, bar in zip(self.numbers, self.ends, self.bars, strict=True) if bar and node in pair
        )
        first, _ = released_end(self.numbers, self.ends, self.bars, node)
        return (first, *(n for n in at_node if n != first))

    def end_stiffness(self, node: int) -> float:
        """Return the rotational stiffness, N m/rad, of the member end released by a joint at a node."""
        number, end = self.end_at(node)
        return float(self.bending[self.position(number), ROTATION_ROWS[end], ROTATION_ROWS[end]])

    @property
    def joints(self) -> tuple[int, ...]:
        """Nodes at which two bars or more meet."""
        ends = [node for pair, bar in zip(self.ends, self.bars, strict=True) if bar for node in pair]
        nodes, counts = np.unique(np.array(ends, int), return_counts=True)
        return tuple(int(node) for node in nodes[counts > 1])

    def scaled(
        self, *, mass: float | FloatArray, stiffness: float | FloatArray, loss: float = 1.0
    ) -> "MemberTable":
        """Return the table with mass, stiffness and stiffness-proportional damping multiplied.

        Parameters
        ----------
        mass, stiffness
            Factors of all members, or (n_members,) of each.
        """
        m, k = (np.reshape(factor, (-1, 1, 1)) for factor in (mass, stiffness))
        return replace(
            self,
            mass=self.mass * m,
            axial=self.axial * k,
            bending=self.bending * k,
            losses=self.losses.scaled(loss),
            shear=self.shear.scaled(mass=mass, stiffness=stiffness),
        )

    def sheared(self, amount: float, consistent_mass: float) -> "MemberTable":
        """Return the table with added shear flexibility and rotary inertia of every member."""
        mass, bending = self._sheared(self.shear, amount, consistent_mass)
        shear = self.shear.more(amount, consistent_mass)
        return replace(self, mass=self.mass + mass, bending=self.bending + bending, shear=shear)

    def _sheared(self, shear: Shear, amount: float, consistent_mass: float) -> tuple[FloatArray, FloatArray]:
        """Return the changes of mass and bending stiffness by added shear, (n, w, w) each."""
        more = self.rows.shape[1] - 6
        if more < 0:  # no bars
            return self.mass[:1] * 0.0, self.bending[:1] * 0.0
        added = shear.added(amount, consistent_mass)
        mass, bending = (np.pad(part, ((0, 0), (0, more), (0, more))) for part in added)
        return mass, bending

    def sum(self, parts: FloatArray, n: int) -> csc_array:
        """Return the (n, n) sum of member matrices (n_members, w, w)."""
        r = np.broadcast_to(self.rows[:, :, None], parts.shape)
        c = np.broadcast_to(self.rows[:, None, :], parts.shape)
        valid = (r >= 0) & (c >= 0)
        return csc_array(coo_array((parts[valid], (r[valid], c[valid])), shape=(n, n)))
