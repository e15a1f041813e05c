"""Replies of structures."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from modallab.api.replies import replies_of, stored_reply
from modallab.core.dof import Dof
from modallab.core.physics_warning import PhysicsWarning
from modallab.core.reply import Vector
from modallab.fe.modes import ModalBasis
from modallab.fe.structure import Structure
from modallab.rig.plausibility import structure_warnings
from modallab.store.base import Entry


@dataclass(frozen=True)
class StructureSummary:
    """Size of a stored structure, and its groups of members."""

    n_nodes: int
    """Number of nodes."""
    n_dofs: int
    """Number of degrees of freedom."""
    members: int
    """Number of members."""
    groups: Mapping[str, tuple[int, ...]]
    """Numbers of members, by the name under which they may be updated."""


@dataclass(frozen=True, eq=False)
class ElasticModes:
    """Elastic modes of a structure, ascending in frequency."""

    frequencies: Vector
    """Hz, (n_modes,) natural frequencies."""
    loss_factors: Vector
    """(n_modes,) loss factors."""
    n_rigid_body: int
    """Number of rigid-body modes, which are not listed."""


@dataclass(frozen=True)
class MemberNodes:
    """Member with its nodes."""

    number: int
    """Number of the member."""
    nodes: tuple[int, ...]
    """Numbers of its nodes: both ends of a bar, the perimeter of a plate element."""


@dataclass(frozen=True)
class Geometry:
    """Geometry of a structure, with its free degrees of freedom."""

    nodes: Mapping[int, tuple[float, ...]]
    """m, coordinates X, Y and, where the structure has it, Z, by the number of the node."""
    members: tuple[MemberNodes, ...]
    """Members: bars, then others."""
    dofs: tuple[Dof, ...]
    """Free degrees of freedom, node by node."""


StructureReply = stored_reply(
    StructureSummary,
    "Structure",
    warnings=(replies_of(PhysicsWarning), "What is surely a slip of a unit or a setting."),
)
ModesReply = stored_reply(ElasticModes, "StructureModes")
GeometryReply = stored_reply(Geometry, "StructureGeometry")


def structure_reply(structure: Structure, entry: Entry) -> Any:
    """Return the reply of a stored structure."""
    summary = StructureSummary(
        len(structure.nodes),
        len(structure.dofs),
        len(structure.all_members),
        {name: tuple(numbers) for name, numbers in structure.groups.items()},
    )
    return StructureReply.of(summary, entry, warnings=structure_warnings(structure))


def modes_reply(basis: ModalBasis, n_rigid_body: int, entry: Entry) -> Any:
    """Return the reply of the elastic modes of a stored structure."""
    return ModesReply.of(ElasticModes(basis.frequencies, basis.loss_factors, n_rigid_body), entry)


def geometry_reply(structure: Structure, entry: Entry) -> Any:
    """Return the reply of the geometry of a stored structure."""
    members = tuple(MemberNodes(member.number, member.nodes) for member in structure.all_members)
    return GeometryReply.of(Geometry(structure.nodes, members, structure.dofs), entry)
