"""Dynamic system: matrices of a structure with attached masses, springs, dampers and member changes."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.sparse import csc_array

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnknownDofError
from modallab.fe.alteration import Alteration
from modallab.fe.attached_system import AttachedSystem
from modallab.fe.attachment import MATRIX_NAMES, Attachment, with_attachments, with_internal_motions
from modallab.fe.cache import CacheSlot
from modallab.fe.damping import ViscousDamping
from modallab.fe.elastic_supports import support_springs
from modallab.fe.loaded_modes import half_power, loaded_modes, only_loads
from modallab.fe.member_table import MemberTable
from modallab.fe.modal_damping import ModalLossFactors
from modallab.fe.modes import ModalBasis
from modallab.fe.rebuilding import grounded, rebuilt
from modallab.fe.settings import CACHE, EIGENSOLUTION

VARIANTS: "CacheSlot[DynamicSystem]" = CacheSlot("variants", CACHE.variants)
MEMBER_FACTORS: "CacheSlot[DynamicSystem]" = CacheSlot("member factors", CACHE.member_factors)

_UNCHANGED: Mapping[str, Any] = {"alterations": {}, "supports": {}, "support_springs": None}


@dataclass(frozen=True, eq=False)
class DynamicSystem(AttachedSystem):
    """Mass, stiffness and damping of a structure with its DoFs, and its attachments.

    The matrices are never changed: masses, springs and corrected members are attachments, so that
    modes are solved for once and every loaded variant follows by the Woodbury identity.
    """

    alterations: Mapping[int, tuple[Alteration, Attachment]] = field(default_factory=dict)  # by member
    supports: Mapping[Dof, float] = field(default_factory=dict)  # m/N or rad/(N m), of those not rigid
    support_springs: Attachment | None = None  # of all elastic supports and the members there

    def change_member(
        self, number: int, *, mass: float = 0.0, axial: float = 0.0, bending: float = 0.0
    ) -> "DynamicSystem":
        """Return the system with a member's mass and stiffness parts changed by relative amounts.

        Its damping follows the structure's damping law, as in an assembly with the new factors.
        """
        return self.alter(number, Alteration(1 + mass, 1 + axial, 1 + bending))

    def add_joint(
        self, node: int, flexibility: float, consistent_mass: float = 1.0, member: int | None = None
    ) -> "DynamicSystem":
        """Return the system with a rotational spring, rad/(N m), between two sides of a node.

        On one side is a member, on the other side all others.

        Parameters
        ----------
        consistent_mass
            Share of the kink that the member's mass matrix has; 0 leaves it unchanged.
        member
            Number of the member; None: the first one that ends at the node.

        Raises
        ------
        InvalidInputError
            If fewer than two members meet at the node, or the member is none of them.
        """
        number, end = self._member_table.end_at(node, member)
        joints = (0.0, flexibility) if end else (flexibility, 0.0)
        return self.alter(number, Alteration(joints=joints, consistent_mass=consistent_mass))

    def alter(self, number: int, alteration: Alteration) -> "DynamicSystem":
        """Return the system with a member altered in addition to earlier alterations of it.

        A member has one attachment for all its alterations, as these interact.
        """
        previous, previous_attachment = self.alterations.get(number, (Alteration(), None))
        combined = previous.combined_with(alteration)
        table, n = self._member_table, len(self.dofs)
        if self.supports and table.held.members_at(self.supports)[table.position(number)]:
            return self._supported(self.supports, {number: combined})
        attachment = self._cached_attachment((number, combined), lambda: table.altered(number, combined, n))
        attachments = tuple(a for a in self.attachments if a is not previous_attachment)
        return replace(
            self,
            attachments=(*attachments, attachment),
            alterations={**self.alterations, number: (combined, attachment)},
        )

    def soften_support(self, dof: Dof, flexibility: float) -> "DynamicSystem":
        """Return the system with a spring, m/N (rad/(N m) of a rotation), between a held DoF and the ground.

        Raises
        ------
        UnknownDofError
            If no support holds the DoF.
        """
        held, point = self._member_table.held.dofs, dof.point
        if point not in held:
            raise UnknownDofError(
                f"no support holds {dof}", field="at", value=str(dof), allowed=[str(each) for each in held]
            )
        return self._supported({**self.supports, point: self.supports.get(point, 0.0) + flexibility}, {})

    @property
    def loaded_supports(self) -> tuple[Dof, ...]:
        """Held DoFs that members couple to free ones: those that react to a motion."""
        return () if self.members is None else self.members.loaded_held_dofs

    def stiffness_at_support(self, dof: Dof) -> float:
        """Return the stiffness, N/m (N m/rad of a rotation), of the members at a held DoF, all else held."""
        return self._member_table.held_stiffness(dof)

    def _supported(self, supports: Mapping[Dof, float], altered: Mapping[int, Alteration]) -> "DynamicSystem":
        """Return the system on elastic supports, whose attachment includes alterations of members there."""
        table, n = self._member_table, len(self.dofs)
        at_supports = table.held.members_at(supports)
        previous = {k: own for k, own in self.alterations.items() if at_supports[table.position(k)]}
        alterations = {**{number: alteration for number, (alteration, _) in previous.items()}, **altered}
        key = ("supports", tuple(supports.items()), tuple(alterations.items()))
        springs = self._cached_attachment(key, lambda: support_springs(table, supports, alterations, n))
        replaced = [self.support_springs, *(attachment for _, attachment in previous.values())]
        attachments = tuple(a for a in self.attachments if not any(a is b for b in replaced))
        return replace(
            self,
            attachments=(*attachments, springs),
            alterations={**self.alterations, **{k: (a, springs) for k, a in alterations.items()}},
            supports=supports,
            support_springs=springs,
        )

    @property
    def _member_table(self) -> MemberTable:
        if self.members is None:
            raise InvalidInputError("the system does not know its members", field="members")
        return self.members

    def scaled(self, *, mass: float = 1.0, stiffness: float = 1.0, loss: float = 1.0) -> "DynamicSystem":
        """Return the system with the mass, stiffness or loss of every member multiplied.

        Point masses and springs to ground stay as they are. `loss` multiplies the members' damping in
        proportion to stiffness, beside its change with the stiffness; modal damping is multiplied as a whole.
        """
        if mass == stiffness == loss == 1:
            return self
        table = self._member_table
        modal = self.modal and self.modal.scaled(loss)
        same_shapes = mass == 1 and (stiffness == 1 or not grounded(self.cache, self.stiffness, table))
        return self._rebuilt(
            ("scaled", mass, stiffness, loss),
            lambda: table.scaled(mass=mass, stiffness=stiffness, loss=loss),
            modal,
            stiffness if same_shapes else None,
        )

    def with_member_factors(
        self, *, stiffness: tuple[float, ...] = (), mass: tuple[float, ...] = ()
    ) -> "DynamicSystem":
        """Return the system with the stiffness and mass of each member multiplied.

        Parameters
        ----------
        stiffness, mass
            (n_members,) factors; empty for 1.
        """
        table = self._member_table
        k, m = (np.array(factors or (1.0,)) for factors in (stiffness, mass))
        key = ("member factors", stiffness, mass)
        return self._rebuilt(key, lambda: table.scaled(stiffness=k, mass=m), self.modal, slot=MEMBER_FACTORS)

    def converted(self, share: float, omega: float) -> "DynamicSystem":
        """Return the system with a fraction, 0 to 1, of its damping converted to the other damping law.

        Viscous damping becomes hysteretic where the structure's law is viscous, else hysteretic damping
        becomes viscous; both dissipate the same energy at `omega`, rad/s.
        """
        table, modal = self._member_table, self.modal
        if isinstance(table.law, ViscousDamping):
            losses = table.losses.to_hysteretic(share, omega)
        else:
            losses = table.losses.to_viscous(share, omega)
            modal = modal and modal.to_viscous(share, omega)
        members = replace(table, losses=losses)
        return self._rebuilt(("converted", share, omega), lambda: members, modal, eigenvalue_ratio=1.0)

    def with_modal_loss(self, more: tuple[float, ...]) -> "DynamicSystem":
        """Return the system with additional loss factors of its lowest elastic modes.

        Structural damping sum eta_r lambda_r (M phi_r)(M phi_r)^T of the matrices' own modes, without
        attachments; an added loss factor may be negative as long as the sum is not.
        """
        if not any(more):
            return self
        modal = (self.modal or ModalLossFactors((0.0,))).with_modal_loss(more)
        key = ("modal loss", more)
        return self._rebuilt(key, lambda: self._member_table, modal, eigenvalue_ratio=1.0)

    def with_loss_of_altered_modes(self) -> "DynamicSystem":
        """Return the system whose additional modal loss factors are of its modes with altered members.

        Those of `with_modal_loss` are of modes of the matrices, which no alteration changes. A structure
        too large for dense solutions keeps them: its modes would be solved for at every alteration.
        """
        modal = self.modal
        if modal is None or not any(modal.more) or not (self.alterations or self.supports):
            return self
        if len(self.dofs) >= EIGENSOLUTION.dense_dofs:
            return self
        numbers = tuple((number, alteration) for number, (alteration, _) in self.alterations.items())
        key = ("modal loss of altered modes", modal, numbers, tuple(self.supports.items()))
        loss = self._cached_attachment(key, lambda: self._loss_of_altered_modes(modal))
        without = replace(modal, more=())
        variant = ("without modal loss", without)
        return self._rebuilt(variant, lambda: self._member_table, without, eigenvalue_ratio=1.0).attach(loss)

    def _loss_of_altered_modes(self, modal: ModalLossFactors) -> Attachment:
        """Return the additional modal loss factors as an attachment to the modes with altered members."""
        altered = replace(self, attachments=self._of_members).folded()
        basis = altered.undamped_modes(np.inf).elastic(len(modal.more))
        additional = replace(modal, loss_factors=(0.0,))
        # Of the rotations inside joints the inertia is negligible: they stay without a loss of their own.
        loss = additional.attachment(altered.mass, basis.eigenvalues.real, basis.shapes.real)
        return replace(loss, columns=loss.columns[: len(self.dofs)])

    @property
    def _of_members(self) -> tuple[Attachment, ...]:
        """Attachments that alter members and supports."""
        of_members = [self.support_springs, *(attachment for _, attachment in self.alterations.values())]
        return tuple(a for a in self.attachments if any(a is b for b in of_members))

    def sheared(self, amount: float, consistent_mass: float = 1.0) -> "DynamicSystem":
        """Return the system with added shear flexibility and rotary inertia in every member.

        An amount of 1 turns Bernoulli-Euler members into Timoshenko members; the latter stay as they are.

        Parameters
        ----------
        consistent_mass
            Share of the shear flexibility in the shapes of the mass matrix; 0: those of Bernoulli and Euler.
        """
        key = "sheared", amount, consistent_mass
        return self._rebuilt(key, lambda: self._member_table.sheared(amount, consistent_mass), self.modal)

    def _rebuilt(
        self,
        key: tuple[object, ...],
        members: Callable[[], MemberTable],
        modal: ModalLossFactors | None,
        eigenvalue_ratio: float | None = None,
        *,
        slot: "CacheSlot[DynamicSystem]" = VARIANTS,
    ) -> "DynamicSystem":
        """Return the system of other members, with all attachments of this one.

        Matrices are cached by `key`, so that their modes are solved for once. `eigenvalue_ratio`:
        eigenvalues of the new matrices over those of this system, None for other mode shapes.
        """

        def make() -> DynamicSystem:
            table = members()
            matrices = rebuilt(self._matrices, len(self.dofs), self._member_table, table)
            bare = replace(self, attachments=(), **_UNCHANGED)
            return DynamicSystem(
                **matrices,  # type: ignore[arg-type]
                dofs=self.dofs,
                rigid=self.rigid,
                members=table,
                modal=modal,
                eigenvalue_reference=None if eigenvalue_ratio is None else (bare, eigenvalue_ratio),
                dof_cache=self.dof_cache,
            )

        of_members = self._of_members
        attachments = tuple(a for a in self.attachments if not any(a is b for b in of_members))
        variant = self.cache.compute(slot, key, make)
        system = replace(variant, attachments=attachments, **_UNCHANGED)
        for number, (alteration, _) in self.alterations.items():
            system = system.alter(number, alteration)
        return system._supported(self.supports, {}) if self.supports else system

    @property
    def _matrices(self) -> dict[str, csc_array | None]:
        return {name: getattr(self, name) for name in MATRIX_NAMES}

    def folded(self) -> "DynamicSystem":
        """Return the same system with every attachment added to the matrices.

        Internal coordinates of the attachments become rows after those of the DoFs.
        """
        attachments = self._all_attachments
        out = with_attachments(self._matrices, len(self.dofs), attachments)
        rigid = None if self.rigid is None else with_internal_motions(self.rigid, attachments)
        return DynamicSystem(**out, dofs=self.dofs, rigid=rigid, members=self.members)  # type: ignore[arg-type]

    @property
    def _all_attachments(self) -> tuple[Attachment, ...]:
        """All attachments, modal damping among them as the last one."""
        damping = self.modal_damping
        return self.attachments if damping is None else (*self.attachments, damping)

    def first_modes(self, count: int) -> ModalBasis:
        """Return modes of the system with its attachments: `count` elastic ones or more, or all."""
        system = self.folded() if self.attachments else self
        undamped = system.lowest_undamped_modes(count)
        return system.base_modes(undamped.frequency_max / EIGENSOLUTION.band_margin)

    def modes(self, frequency_max: float = 0.0) -> ModalBasis:
        """Return modes of the system with its attachments; see `base_modes` for how many."""
        system = self.folded() if self.attachments else self
        return system.base_modes(frequency_max)

    def resonances(self, frequency_max: float) -> tuple[FloatArray, FloatArray]:
        """Return frequency and half the half-power bandwidth of each elastic mode, Hz.

        Off-diagonal modal damping is neglected: several times faster, and accurate enough for bandwidths.
        """
        if len(self.dofs) < EIGENSOLUTION.dense_dofs and only_loads(self.attachments):
            basis = loaded_modes(self.undamped_modes(np.inf), self.attachments)
            return half_power(basis, self.damping, self.viscous, self._all_attachments)
        system = self.folded() if self.attachments or self.modal else self
        basis = system.undamped_modes(EIGENSOLUTION.band_margin * frequency_max)
        return half_power(basis.elastic(), system.damping, system.viscous)
