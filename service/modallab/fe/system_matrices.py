"""Assembled matrices of a structure and their undamped and damped modes."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import csc_array

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import UnknownDofError, bounds
from modallab.fe.attachment import Attachment
from modallab.fe.cache import Cache, CacheSlot
from modallab.fe.member_table import MemberTable
from modallab.fe.modal_damping import ModalLossFactors
from modallab.fe.modes import ModalBasis, first_basis, undamped_basis
from modallab.fe.settings import CACHE, EIGENSOLUTION

ROWS_BY_DOF: CacheSlot[dict[Dof, int]] = CacheSlot("rows by DoF")
MODAL_DAMPING: CacheSlot[Attachment] = CacheSlot("modal damping", CACHE.variants)
UNDAMPED_MODES: CacheSlot[ModalBasis] = CacheSlot("undamped modes")
DAMPED_MODES: CacheSlot[ModalBasis] = CacheSlot("damped modes")


@dataclass(frozen=True, eq=False)
class SystemMatrices:
    """Mass, stiffness and damping of a structure with its DoFs, without attachments.

    `eigenvalue_reference` is a system with the same undamped mode shapes and the ratio of this system's
    eigenvalues to its own: the eigensolution is done there. `cache` holds what depends on the matrices
    alone; all variants of a system share it. `dof_cache` holds what depends on the DoFs alone; systems of
    the same DoFs with other members share it too.
    """

    mass: csc_array  # (n, n) kg
    stiffness: csc_array  # (n, n) N/m
    dofs: tuple[Dof, ...]
    damping: csc_array | None = None  # (n, n) N/m, structural: K + iD
    viscous: csc_array | None = None  # (n, n) N s/m
    rigid: FloatArray | None = None  # (n, n_rigid) motions that strain no member
    members: MemberTable | None = None
    modal: ModalLossFactors | None = None  # modal damping of the matrices, attachments left out
    eigenvalue_reference: "tuple[SystemMatrices, float] | None" = None
    cache: Cache = field(default_factory=Cache, repr=False)
    dof_cache: Cache = field(default_factory=Cache, repr=False)

    @cached_property
    def _rows(self) -> dict[Dof, int]:
        return self.dof_cache.compute(ROWS_BY_DOF, None, lambda: {dof: i for i, dof in enumerate(self.dofs)})

    def index(self, dof: Dof) -> int:
        """Return the row of a DoF.

        Raises
        ------
        UnknownDofError
            If the system has no such DoF.
        """
        try:
            return self._rows[dof.point]
        except KeyError:
            at_node = [str(free) for free in self.dofs if free.node == dof.node]
            nodes = {"nodes": bounds(self.dofs[0].node, self.dofs[-1].node)}
            raise UnknownDofError(
                f"the structure has no degree of freedom {dof}",
                field="dof",
                value=str(dof),
                allowed=at_node or nodes,
            ) from None

    def translations(self, node: int) -> tuple[Dof, ...]:
        """Return the translational DoFs of a node.

        Raises
        ------
        UnknownDofError
            If the node has none.
        """
        translations = tuple(d for d in self.dofs if d.node == node and d.translational)
        if not translations:
            raise UnknownDofError(f"node {node} has no translation to carry a mass", field="node", value=node)
        return translations

    def selection(self, dofs: tuple[Dof, ...]) -> FloatArray:
        """Return the (n, n_dof) columns that select DoFs, with their signs."""
        columns = np.zeros((len(self.dofs), len(dofs)))
        columns[[self.index(d) for d in dofs], np.arange(len(dofs))] = [d.sign for d in dofs]
        return columns

    def base_modes(self, frequency_max: float) -> ModalBasis:
        """Return the damped modes of the matrices without attachments.

        All modes of a system below `EIGENSOLUTION.dense_dofs` DoFs, else those up to
        `EIGENSOLUTION.band_margin` times `frequency_max`, Hz. Solved once for all variants of the system.
        """
        limit = EIGENSOLUTION.band_margin * frequency_max
        basis = self.cache.get(DAMPED_MODES)
        if basis is not None and basis.frequency_max >= limit:
            return basis
        losses = None if self.members is None else self.members.losses
        undamped = self.undamped_modes(limit)
        return self.cache.put(DAMPED_MODES, undamped.damped(self.damping, self.viscous, self.modal, losses))

    def undamped_modes(self, limit: float) -> ModalBasis:
        """Return the undamped modes of the matrices without attachments up to `limit`, Hz, or all."""
        basis = self.cache.get(UNDAMPED_MODES)
        if basis is not None and basis.frequency_max >= limit:
            return basis
        if self.eigenvalue_reference:
            reference, ratio = self.eigenvalue_reference
            # Limits in few steps: systems that soften gradually would each ask for a slightly wider band.
            growth = EIGENSOLUTION.band_growth
            factor = growth ** np.ceil(max(-np.log(ratio) / 2 / np.log(growth), 0.0))
            basis = reference.undamped_modes(limit * factor).with_scaled_eigenvalues(ratio)
        else:
            frequency_max = np.inf if len(self.dofs) < EIGENSOLUTION.dense_dofs else limit
            basis = undamped_basis(self.mass, self.stiffness, self.rigid, frequency_max=frequency_max)
        return self.cache.put(UNDAMPED_MODES, basis)

    @property
    def modal_damping(self) -> Attachment | None:
        """Modal damping of the matrices as an attachment; None without."""
        if self.modal is None:
            return None
        modal = self.modal

        def make() -> Attachment:
            basis = self.undamped_modes(EIGENSOLUTION.modal_damping_band).elastic()
            return modal.attachment(self.mass, basis.eigenvalues.real, basis.shapes.real)

        return self.cache.compute(MODAL_DAMPING, modal, make)

    def lowest_undamped_modes(self, count: int) -> ModalBasis:
        """Return at least the `count` lowest undamped elastic modes, or all if there are fewer."""
        basis = self.cache.get(UNDAMPED_MODES)
        if basis is not None and len(basis.eigenvalues) - basis.n_rigid_body >= count:
            return basis
        if self.eigenvalue_reference:
            reference, ratio = self.eigenvalue_reference
            basis = reference.lowest_undamped_modes(count).with_scaled_eigenvalues(ratio)
        elif len(self.dofs) < EIGENSOLUTION.dense_dofs:
            return self.undamped_modes(np.inf)
        else:
            basis = first_basis(self.mass, self.stiffness, self.rigid, count)
        return self.cache.put(UNDAMPED_MODES, basis)
