"""The matrices of a structure, and what is attached to it without touching them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np
from scipy.sparse import csc_array

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnknownDofError
from modallab.fe.alteration import Alteration
from modallab.fe.attachment import (
    MATRIX_NAMES,
    Attachment,
    attached_stiffness,
    damper,
    extended_columns,
    oscillator,
    padded,
    spring,
    stacked_columns,
    with_blocks,
    with_internal_motions,
)
from modallab.fe.cache import cached
from modallab.fe.damping import ViscousDamping
from modallab.fe.loaded_modes import half_power, loaded_modes, only_loads
from modallab.fe.member_table import MemberTable
from modallab.fe.modal_damping import ModalLossFactors
from modallab.fe.modes import ModalBasis, first_basis, undamped_basis
from modallab.fe.rebuilding import grounded, rebuilt
from modallab.fe.settings import CACHE, EIGENSOLUTION

# Every run of a test hangs the same things on its structure: the latest are kept.


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
    modal: ModalLossFactors | None = None  # of the matrices alone
    # A system with the same undamped shapes, and how many times its eigenvalues these are: solved for there.
    alike: "tuple[DynamicSystem, float] | None" = None
    altered: Mapping[int, tuple[Alteration, Attachment]] = field(default_factory=dict)  # by member
    shared: dict[str, object] = field(default_factory=dict, repr=False)  # solved once for all variants

    @cached_property
    def _index(self) -> dict[Dof, int]:
        return cached(self.shared, "rows", None, lambda: {dof: i for i, dof in enumerate(self.dofs)})

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
        return self.add_masses((node,), mass)

    def add_masses(self, nodes: Sequence[int], mass: float) -> "DynamicSystem":
        """Return the system with the same mass, kg, at each of some nodes."""
        hung = [self._known((node, mass), partial(self._mass, node, mass)) for node in nodes]
        return replace(self, attachments=(*self.attachments, *hung))

    def _known(self, key: tuple[object, ...], make: Callable[[], Attachment]) -> Attachment:
        """Return what was attached to the same matrices before, or else make it."""
        return cached(
            self.shared,
            "hung",
            key,
            make,
            min(CACHE.attachments, 1 + CACHE.attachment_rows // len(self.dofs)),
        )

    def _mass(self, node: int, mass: float) -> Attachment:
        moved = tuple(d for d in self.dofs if d.node == node and d.translational)
        if not moved:
            raise UnknownDofError(f"node {node} has no translation to carry a mass", field="node", value=node)
        return Attachment(self.selection(moved), mass=mass * np.eye(len(moved)))

    def add_spring(self, dof: Dof, stiffness: float) -> "DynamicSystem":
        """Return the system with a spring, N/m (N m for a rotation), from a DoF to the ground."""
        return self._hang(dof, spring, stiffness)

    def add_damper(self, dof: Dof, viscous: float) -> "DynamicSystem":
        """Return the system with a viscous damper, N s/m (N m s for a rotation), from a DoF to the ground."""
        return self._hang(dof, damper, viscous)

    def add_oscillator(self, dof: Dof, mass: float, frequency: float, loss_factor: float) -> "DynamicSystem":
        """Return the system with a mass, kg, on a damped spring that hangs on a DoF.

        Parameters
        ----------
        frequency
            Hz, of the mass on its spring when the DoF is held.
        loss_factor
            Of the spring.
        """
        return self._hang(dof, oscillator, mass, frequency, loss_factor)

    def _hang(self, dof: Dof, make: Callable[..., Attachment], *numbers: float) -> "DynamicSystem":
        """Return the system with one thing more that hangs on a DoF, made from its column and numbers."""
        key = (make, dof, numbers)
        return self.attach(self._known(key, lambda: make(self.selection((dof,)), *numbers)))

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
        both = old.combined_with(alteration)
        table, n = self._known_members, len(self.dofs)
        new = self._known((number, both), lambda: table.altered(number, both, n))
        rest = tuple(a for a in self.attachments if a is not attachment)
        return replace(self, attachments=(*rest, new), altered={**self.altered, number: (both, new)})

    @property
    def _known_members(self) -> MemberTable:
        if self.members is None:
            raise InvalidInputError("the system does not know its members", field="members")
        return self.members

    def scaled(self, *, mass: float = 1.0, stiffness: float = 1.0, loss: float = 1.0) -> "DynamicSystem":
        """Return the system with the mass, stiffness or loss of every member multiplied.

        Point masses and springs to ground stay as they are. `loss` is what members lose in proportion to
        their stiffness, beside what they do as that changes; of modal damping it is all.
        """
        if mass == stiffness == loss == 1:
            return self
        table = self._known_members
        modal = self.modal and self.modal.scaled(loss)
        solved = mass == 1 and (stiffness == 1 or not grounded(self.shared, self.stiffness, table))
        return self._rebuilt(
            ("scaled", mass, stiffness, loss),
            lambda: table.scaled(mass=mass, stiffness=stiffness, loss=loss),
            modal,
            stiffness if solved else None,
        )

    def converted(self, share: float, omega: float) -> "DynamicSystem":
        """Return the system with a share of its members' loss under the other law, alike at `omega` rad/s.

        Viscous damping turns hysteretic where the structure's law is viscous; else it is the other way.
        """
        table, modal = self._known_members, self.modal
        if isinstance(table.law, ViscousDamping):
            losses = table.losses.to_hysteretic(share, omega)
        else:
            losses = table.losses.to_viscous(share, omega)
            modal = modal and modal.to_viscous(share, omega)
        members = replace(table, losses=losses)
        return self._rebuilt(("converted", share, omega), lambda: members, modal, stretch=1.0)

    def with_modal_loss(self, more: tuple[float, ...]) -> "DynamicSystem":
        """Return the system whose lowest elastic modes have so much more of a loss factor each.

        Structural damping sum eta_r lambda_r (M phi_r)(M phi_r)^T of the matrices' own modes, without what
        is attached; a loss factor may be less than none as long as the whole is not.
        """
        if not any(more):
            return self
        modal = (self.modal or ModalLossFactors((0.0,))).with_modal_loss(more)
        return self._rebuilt(("losing", more), lambda: self._known_members, modal, stretch=1.0)

    def sheared(self, amount: float) -> "DynamicSystem":
        """Return the system with so much more of shear flexibility and rotary inertia in every member.

        1 turns members of Bernoulli and Euler into Timoshenko's; those that are his have it already.
        """
        return self._rebuilt(("sheared", amount), lambda: self._known_members.sheared(amount), self.modal)

    def _rebuilt(
        self,
        key: tuple[object, ...],
        members: Callable[[], MemberTable],
        modal: ModalLossFactors | None,
        stretch: float | None = None,
    ) -> "DynamicSystem":
        """Return the system of other members, with all that is attached to this one.

        Asked for again with the same key, the same matrices come back, so that their modes are solved for
        once. `stretch` says how many times their eigenvalues are this system's, where shapes are its own.
        """

        def make() -> DynamicSystem:
            table = members()
            matrices = rebuilt(self._matrices, len(self.dofs), self._known_members, table)
            alike = None if stretch is None else (replace(self, attachments=(), altered={}), stretch)
            rest = {"rigid": self.rigid, "members": table, "modal": modal, "alike": alike}
            return DynamicSystem(**matrices, dofs=self.dofs, **rest)  # type: ignore[arg-type]

        own = [attachment for _, attachment in self.altered.values()]
        rest = tuple(a for a in self.attachments if not any(a is b for b in own))
        system = replace(cached(self.shared, "scaled", key, make), attachments=rest, altered={})
        for number, (alteration, _) in self.altered.items():
            system = system.alter(number, alteration)
        return system

    @property
    def _matrices(self) -> dict[str, csc_array | None]:
        return {name: getattr(self, name) for name in MATRIX_NAMES}

    def folded(self) -> "DynamicSystem":
        """Return the same system with every attachment added into the matrices.

        Coordinates of the attachments' own become rows behind those of the DoFs.
        """
        hung = self._hung
        columns_of = extended_columns(len(self.dofs), hung)
        n = len(self.dofs) + sum(a.inner for a in hung)
        out = {name: padded(matrix, n) for name, matrix in self._matrices.items()}
        for name, total in out.items():
            each = [
                (columns, small)
                for attachment, columns in zip(hung, columns_of, strict=True)
                if (small := getattr(attachment, name)) is not None and small.any()
            ]
            out[name] = with_blocks(total, each, n)
        rigid = None if self.rigid is None else with_internal_motions(self.rigid, hung)
        return DynamicSystem(**out, dofs=self.dofs, rigid=rigid, members=self.members)  # type: ignore[arg-type]

    @property
    def _hung(self) -> tuple[Attachment, ...]:
        """All attachments, and modal damping as one."""
        if self.modal is None:
            return self.attachments
        modal = self.modal

        def make() -> Attachment:
            basis = self._undamped(EIGENSOLUTION.modal_damping_band).elastic()
            return modal.attachment(self.mass, basis.eigenvalues.real, basis.shapes.real)

        return (*self.attachments, cached(self.shared, "modal", modal, make))

    @property
    def stacked_columns(self) -> FloatArray:
        """(n, R): the columns of all attachments side by side."""
        return stacked_columns(len(self.dofs), self.attachments)

    def attached_stiffness(self, omega: FloatArray) -> ComplexArray:
        """Return the dynamic stiffness of all attachments, (n_freq, R, R), block by block."""
        return attached_stiffness(self.attachments, omega)

    def base_modes(self, frequency_max: float) -> ModalBasis:
        """Return the modes of the matrices without attachments, solved once for all variants of the system.

        All modes of a system below `EIGENSOLUTION.dense_dofs` DoFs, else those up to twice
        `frequency_max`, Hz.
        """
        known = self.shared.get("basis")
        if isinstance(known, ModalBasis) and known.frequency_max >= EIGENSOLUTION.band_margin * frequency_max:
            return known
        losses = None if self.members is None else self.members.losses
        basis = self._undamped(EIGENSOLUTION.band_margin * frequency_max).damped(
            self.damping, self.viscous, self.modal, losses
        )
        self.shared["basis"] = basis
        return basis

    def _undamped(self, limit: float) -> ModalBasis:
        """Return undamped modes of the matrices alone, up to `limit`, Hz, or all."""
        known = self.shared.get("undamped")
        if isinstance(known, ModalBasis) and known.frequency_max >= limit:
            return known
        if self.alike:
            other, stretch = self.alike
            # In few steps, or systems that get softer bit by bit would each ask for a little more.
            growth = EIGENSOLUTION.band_growth
            wider = growth ** np.ceil(max(-np.log(stretch) / 2 / np.log(growth), 0.0))
            basis = other._undamped(limit * wider).with_scaled_eigenvalues(stretch)
        else:
            top = np.inf if len(self.dofs) < EIGENSOLUTION.dense_dofs else limit
            basis = undamped_basis(self.mass, self.stiffness, self.rigid, frequency_max=top)
        self.shared["undamped"] = basis
        return basis

    def _first(self, count: int) -> ModalBasis:
        """Return undamped modes of the matrices alone, `count` elastic ones or more, or all."""
        known = self.shared.get("undamped")
        if isinstance(known, ModalBasis) and len(known.eigenvalues) - known.n_rigid_body >= count:
            return known
        if self.alike:
            other, stretch = self.alike
            basis = other._first(count).with_scaled_eigenvalues(stretch)
        elif len(self.dofs) < EIGENSOLUTION.dense_dofs:
            return self._undamped(np.inf)
        else:
            basis = first_basis(self.mass, self.stiffness, self.rigid, count)
        self.shared["undamped"] = basis
        return basis

    def first_modes(self, count: int) -> ModalBasis:
        """Return modes of the system with all its attachments, `count` elastic ones or more, or all."""
        system = self.folded() if self.attachments else self
        return system.base_modes(system._first(count).frequency_max / EIGENSOLUTION.band_margin)

    def modes(self, frequency_max: float = 0.0) -> ModalBasis:
        """Return modes of the system with all its attachments; see `base_modes` for how many."""
        system = self.folded() if self.attachments else self
        return system.base_modes(frequency_max)

    def resonances(self, frequency_max: float) -> tuple[FloatArray, FloatArray]:
        """Return frequency and half the half-power bandwidth of each elastic mode, Hz.

        Damping between modes is left out: several times faster, and near enough for widths.
        """
        if len(self.dofs) < EIGENSOLUTION.dense_dofs and only_loads(self.attachments):
            basis = loaded_modes(self._undamped(np.inf), self.attachments)
            return half_power(basis, self.damping, self.viscous, self._hung)
        whole = self.folded() if self.attachments or self.modal else self
        return half_power(
            whole._undamped(EIGENSOLUTION.band_margin * frequency_max).elastic(), whole.damping, whole.viscous
        )
