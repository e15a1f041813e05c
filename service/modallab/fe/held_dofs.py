"""Degrees of freedom that supports hold: which members reach them, and what they would carry."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.fe.members import AnyMember, Member, Plate
from modallab.fe.structure import ACROSS, PLANE, Structure


@dataclass(frozen=True, eq=False)
class HeldDofs:
    """Degrees of freedom of members that supports hold, which are no rows of the system."""

    dofs: tuple[Dof, ...]
    """(n_held,) in the order of the structure's nodes."""
    rows: IntArray
    """(n_members, w) place among `dofs` of each of a member's DoFs, -1 of others."""
    masses: FloatArray
    """(n_held,) kg, point masses there; 0 of a rotation."""

    @classmethod
    def of(cls, structure: Structure, width: int) -> "HeldDofs":
        """Return those of a structure whose members have up to `width` DoFs."""
        place = {dof: i for i, dof in enumerate(structure.held_dofs)}
        rows = np.full((len(structure.all_members), width), -1)
        nodes = {dof.node for dof in place}
        for e, member in enumerate(structure.all_members):
            if not nodes.isdisjoint(member.nodes):
                names = _dofs_of(structure, member)
                rows[e, : len(names)] = [-1 if dof is None else place.get(dof, -1) for dof in names]
        masses = np.zeros(len(place))
        for point in structure.masses:
            masses[[i for dof, i in place.items() if dof.node == point.node and dof.translational]] += (
                point.mass
            )
        return cls(tuple(place), rows, masses)

    def members_at(self, dofs: Collection[Dof]) -> BoolArray:
        """Return which members (n_members,) reach one of some held DoFs."""
        places = [i for i, dof in enumerate(self.dofs) if dof in dofs]
        return np.asarray(np.isin(self.rows, places).any(axis=1))


def _dofs_of(structure: Structure, member: AnyMember) -> list[Dof | None]:
    """Return the DoFs of a member in the order of its matrices, None behind those of a smaller block."""
    if isinstance(member, Member | Plate):
        directions = PLANE if isinstance(member, Member) else ACROSS
        return [Dof(node, direction) for node in member.nodes for direction in directions]
    assert structure.blocks is not None
    dofs = structure.blocks.dofs
    return [None if row < 0 else dofs[row] for row in structure.blocks.rows[member.index]]
