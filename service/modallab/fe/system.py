"""The matrices of a structure, and what is attached to it without touching them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csc_array

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnknownDofError
from modallab.fe.alteration import Alteration
from modallab.fe.attachment import Attachment, grown, motions
from modallab.fe.damping import StructuralDamping, ViscousDamping
from modallab.fe.member_table import MemberTable
from modallab.fe.modes import ModalBasis, modal_basis

SMALL = 250  # DoFs below which a dense eigen-solution is the faster one


@dataclass(frozen=True, eq=False)
class DynamicSystem:
    """Mass, stiffness and damping of a structure with its DoFs, and what is attached to it.

    The matrices are never changed: masses, springs and corrected members are attachments, so that
    modes are solved for once and every loaded variant follows by the Woodbury identity.
    """

    mass: csc_array  # (n, n) kg
    stiffness: csc_array  # (n, n) N/m
    dofs: tuple[Dof, ...]
    damping: csc_array | None = None  # (n, n) N/m, structural: K + iD
    viscous: csc_array | None = None  # (n, n) N s/m
    rigid: FloatArray | None = None  # (n, n_rigid) motions that strain no member
    members: MemberTable | None = None
    attachments: tuple[Attachment, ...] = ()
    altered: Mapping[int, tuple[Alteration, Attachment]] = field(default_factory=dict)  # by member
    shared: dict[str, object] = field(default_factory=dict, repr=False)  # solved once for all variants

    @cached_property
    def _index(self) -> dict[Dof, int]:
        return {dof: i for i, dof in enumerate(self.dofs)}

    def index(self, dof: Dof) -> int:
        """Return the row of a DoF.

        Raises
        ------
        UnknownDofError
            If the system has no such DoF.
        """
        try:
            return self._index[dof.point]
        except KeyError:
            here = ", ".join(str(d) for d in self.dofs if d.node == dof.node)
            raise UnknownDofError(
                f"the structure has no degree of freedom {dof}",
                field="dof",
                value=str(dof),
                allowed=here or f"nodes {self.dofs[0].node} to {self.dofs[-1].node}",
            ) from None

    def selection(self, dofs: tuple[Dof, ...]) -> FloatArray:
        """Return the (n, n_dof) columns that pick DoFs, with their signs."""
        columns = np.zeros((len(self.dofs), len(dofs)))
        columns[[self.index(d) for d in dofs], np.arange(len(dofs))] = [d.sign for d in dofs]
        return columns

    def attach(self, attachment: Attachment) -> "DynamicSystem":
        """Return the system with one more attachment."""
        return replace(self, attachments=(*self.attachments, attachment))

    def add_mass(self, node: int, mass: float) -> "DynamicSystem":
        """Return the system with a mass, kg, that moves with every translation of a node."""
        moved = tuple(d for d in self.dofs if d.node == node and d.translational)
        if not moved:
            raise UnknownDofError(f"node {node} has no translation to carry a mass", field="node", value=node)
        return self.attach(Attachment(self.selection(moved), mass=mass * np.eye(len(moved))))

    def add_spring(self, dof: Dof, stiffness: float) -> "DynamicSystem":
        """Return the system with a spring, N/m (N m for a rotation), from a DoF to the ground."""
        return self.attach(Attachment(self.selection((dof,)), stiffness=np.array([[stiffness]])))

    def add_damper(self, dof: Dof, viscous: float) -> "DynamicSystem":
        """Return the system with a viscous damper, N s/m (N m s for a rotation), from a DoF to the ground."""
        return self.attach(Attachment(self.selection((dof,)), viscous=np.array([[viscous]])))

    def add_oscillator(self, dof: Dof, mass: float, frequency: float, loss_factor: float) -> "DynamicSystem":
        """Return the system with a mass, kg, on a damped spring that hangs on a DoF.

        Parameters
        ----------
        frequency
            Hz, of the mass on its spring when the DoF is held.
        loss_factor
            Of the spring.
        """
        spring = (2 * np.pi * frequency) ** 2 * mass * np.array([[1.0, -1.0], [-1.0, 1.0]])
        own = np.diag([0.0, mass])
        column = self.selection((dof,))
        return self.attach(Attachment(column, own, spring, loss_factor * spring, inner=1))

    def change_member(
        self, number: int, *, mass: float = 0.0, axial: float = 0.0, bending: float = 0.0
    ) -> "DynamicSystem":
        """Return the system with a member's parts changed by these fractions of themselves.

        Its damping follows the law of the structure, as it would in an assembly with the new factors.
        """
        return self.alter(number, Alteration(1 + mass, 1 + axial, 1 + bending))

    def add_joint(self, node: int, flexibility: float) -> "DynamicSystem":
        """Return the system with a rotational spring, rad/(N m), between two sides of a node.

        On one side is the first member that runs into the node, on the other side all the rest.

        Raises
        ------
        InvalidInputError
            If fewer than two members meet at the node.
        """
        number, end = self._known_members.end_at(node)
        joints = (0.0, flexibility) if end else (flexibility, 0.0)
        return self.alter(number, Alteration(joints=joints))

    def alter(self, number: int, alteration: Alteration) -> "DynamicSystem":
        """Return the system with a member altered, beside what was altered of it before.

        One attachment stands for all alterations of a member, so that they act on one another.
        """
        old, attachment = self.altered.get(number, (Alteration(), None))
        both = old.also(alteration)
        new = self._known_members.altered(number, both, len(self.dofs))
        rest = tuple(a for a in self.attachments if a is not attachment)
        return replace(self, attachments=(*rest, new), altered={**self.altered, number: (both, new)})

    @property
    def _known_members(self) -> MemberTable:
        if self.members is None:
            raise InvalidInputError("the system does not know its members", field="members")
        return self.members

    def scaled(self, *, mass: float = 1.0, stiffness: float = 1.0) -> "DynamicSystem":
        """Return the system with the mass or stiffness of every member multiplied.

        Point masses and springs to ground stay as they are.
        """
        table = self._known_members
        return self._rebuilt(
            "scaled", (mass, stiffness), lambda: table.scaled(mass=mass, stiffness=stiffness)
        )

    def sheared(self, amount: float) -> "DynamicSystem":
        """Return the system with so much more of shear flexibility and rotary inertia in every member.

        1 turns members of Bernoulli and Euler into Timoshenko's; those that are his have it already.
        """
        table = self._known_members
        return self._rebuilt("sheared", (amount,), lambda: table.sheared(amount))

    def _rebuilt(
        self, how: str, numbers: tuple[float, ...], members: Callable[[], MemberTable]
    ) -> "DynamicSystem":
        """Return the system of other members, with all that is attached to this one.

        Asked for again with the same numbers, the same matrices come back, so that their modes are solved
        for once; only the last ones are kept.
        """
        known = self.shared.get(how)
        if not (isinstance(known, tuple) and known[0] == numbers):
            known = (numbers, self._with(members()))
            self.shared[how] = known
        matrices: DynamicSystem = known[1]
        own = [attachment for _, attachment in self.altered.values()]
        rest = tuple(a for a in self.attachments if not any(a is b for b in own))
        system = replace(matrices, attachments=rest)
        for number, (alteration, _) in self.altered.items():
            system = system.alter(number, alteration)
        return system

    def _with(self, table: MemberTable) -> "DynamicSystem":
        old, n = self._known_members, len(self.dofs)
        dm = table.sum(table.mass - old.mass, n)
        more = table.axial + table.bending - old.axial - old.bending
        dk = table.sum(more, n)
        damping, viscous = self.damping, self.viscous
        if damping is not None:
            damping = damping + table.sum(table.loss_factor[:, None, None] * more, n)
            if isinstance(table.law, StructuralDamping):
                damping = damping + table.law.mass_coefficient * dm
        if viscous is not None and isinstance(table.law, ViscousDamping):
            viscous = viscous + table.law.mass_coefficient * dm + table.law.stiffness_coefficient * dk
        mass, stiffness = csc_array(self.mass + dm), csc_array(self.stiffness + dk)
        return DynamicSystem(mass, stiffness, self.dofs, damping, viscous, self.rigid, table)

    def folded(self) -> "DynamicSystem":
        """Return the same system with every attachment added into the matrices.

        Coordinates of the attachments' own become rows behind those of the DoFs.
        """
        columns_of = motions(len(self.dofs), self.attachments)
        n = len(self.dofs) + sum(a.inner for a in self.attachments)
        out: dict[str, csc_array | None] = {}
        for name in ("mass", "stiffness", "damping", "viscous"):
            total = grown(getattr(self, name), n)
            for attachment, columns in zip(self.attachments, columns_of, strict=True):
                small = getattr(attachment, name)
                if small is not None and small.any():
                    extra = csc_array(columns @ small @ columns.T)
                    total = extra if total is None else csc_array(total + extra)
            out[name] = total
        rigid = None if self.rigid is None else self._carried(self.rigid)
        return DynamicSystem(**out, dofs=self.dofs, rigid=rigid, members=self.members)  # type: ignore[arg-type]

    def _carried(self, slow: FloatArray) -> FloatArray:
        """Return slow motions (n, k) with those of the attachments' own coordinates below them."""
        rows = [slow]
        for a in self.attachments:
            if a.inner:
                k = np.zeros((a.inner, len(a.columns.T) + a.inner)) if a.stiffness is None else a.stiffness
                rows.append(
                    -np.linalg.pinv(k[-a.inner :, -a.inner :])
                    @ k[-a.inner :, : -a.inner]
                    @ (a.columns.T @ slow)
                )
        return np.vstack(rows)

    @property
    def stacked(self) -> FloatArray:
        """(n, R): the columns of all attachments side by side."""
        return np.hstack([np.zeros((len(self.dofs), 0)), *(a.columns for a in self.attachments)])

    def attached_stiffness(self, omega: FloatArray) -> ComplexArray:
        """Return the dynamic stiffness of all attachments, (n_freq, R, R), block by block."""
        sizes = [a.columns.shape[1] for a in self.attachments]
        z = np.zeros((len(omega), sum(sizes), sum(sizes)), complex)
        start = 0
        for attachment, size in zip(self.attachments, sizes, strict=True):
            z[:, start : start + size, start : start + size] = attachment.dynamic_stiffness(omega)
            start += size
        return z

    def base_modes(self, frequency_max: float) -> ModalBasis:
        """Return modes of the matrices alone, attachments left out: all of them below `SMALL` DoFs,
        else those up to twice `frequency_max`, Hz; solved once for all variants of the system."""
        known = self.shared.get("basis")
        if isinstance(known, ModalBasis) and known.frequency_max >= 2 * frequency_max:
            return known
        basis = modal_basis(
            self.mass,
            self.stiffness,
            self.damping,
            self.viscous,
            self.rigid,
            frequency_max=np.inf if len(self.dofs) < SMALL else 2 * frequency_max,
        )
        self.shared["basis"] = basis
        return basis

    def modes(self, frequency_max: float = 0.0) -> ModalBasis:
        """Return modes of the system with all its attachments; see `base_modes` for how many."""
        system = self.folded() if self.attachments else self
        return system.base_modes(frequency_max)

    def resonances(self, frequency_max: float) -> tuple[FloatArray, FloatArray]:
        """Return frequency and half the half-power bandwidth of each elastic mode, Hz.

        Damping between modes is left out: near enough to say where a spectrum is steep, and several
        times faster than complex modes.
        """
        whole = self.folded()
        basis = replace(whole, damping=None, viscous=None).base_modes(frequency_max).elastic()
        lost = np.zeros(len(basis.eigenvalues))
        for matrix, power in ((whole.damping, 0), (whole.viscous, 1)):
            if matrix is not None:
                modal = (basis.shapes * (matrix @ basis.shapes)).sum(axis=0).real
                lost += modal * (2 * np.pi * basis.frequencies) ** power
        return basis.frequencies, lost / (2 * basis.frequencies * (2 * np.pi) ** 2)
