"""Description of a structure: nodes, members, supports, masses, springs and damping."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from types import MappingProxyType

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from modallab.core.dof import DIRECTIONS, Dof
from modallab.core.errors import InvalidInputError, StructureError, UnknownDofError, bounds
from modallab.core.place import EffectSpec
from modallab.fe.blocks import Blocks
from modallab.fe.damping import Damping, StructuralDamping
from modallab.fe.members import AnyMember, MatrixElement, Plate, not_negative
from modallab.fe.members import Material as Material
from modallab.fe.members import Member as Member
from modallab.fe.members import Section as Section
from modallab.fe.members import positive as positive
from modallab.fe.structure_settings import INPUT

PLANE = ("X", "Y", "RZ")  # of a frame
ACROSS = ("Z", "RX", "RY")  # of a plate


@dataclass(frozen=True)
class Support:
    """Fixed directions of a node."""

    node: int
    directions: tuple[str, ...]


@dataclass(frozen=True)
class PointMass:
    """A mass that moves with every translation of a node."""

    node: int
    mass: float  # kg

    def __post_init__(self) -> None:
        not_negative(self.mass, "mass")


@dataclass(frozen=True)
class GroundSpringElement:
    """A spring between a DoF and the ground."""

    dof: Dof
    stiffness: float  # N/m, or N m for a rotation

    def __post_init__(self) -> None:
        not_negative(self.stiffness, "stiffness")


@dataclass(frozen=True)
class JointSpring:
    """A rotational spring between two sides of a node, which is rigid without it.

    On one side is the first bar that ends at the node, on the other all other members.
    """

    node: int
    stiffness: float  # N m/rad

    def __post_init__(self) -> None:
        positive(self.stiffness, "stiffness")


@dataclass(frozen=True, eq=False)
class Structure:
    """Nodes, members, supports and damping of a structure; checked when it is made.

    Raises
    ------
    StructureError
        If it cannot be analysed: unknown nodes, members of zero length, disconnected parts, every DoF
        fixed.
    """

    nodes: Mapping[int, tuple[float, ...]]  # m; X, Y, and Z where a file brought elements in space
    members: tuple[Member, ...]  # bars
    supports: tuple[Support, ...] = ()
    masses: tuple[PointMass, ...] = ()
    springs: tuple[GroundSpringElement, ...] = ()
    damping: Damping = field(default_factory=StructuralDamping)
    directions: tuple[str, ...] = PLANE  # that every node has, unless held
    effects: tuple[EffectSpec, ...] = ()
    name: str = ""
    non_bar_members: tuple[Plate | MatrixElement, ...] = ()  # members that are no bars
    blocks: Blocks | None = None  # matrices of members that are given by them, and the DoFs there are then
    joints: tuple[JointSpring, ...] = ()  # of bars, one a node

    def __post_init__(self) -> None:
        object.__setattr__(self, "nodes", MappingProxyType(dict(sorted(self.nodes.items()))))
        self._check_nodes()
        self._check_members()
        if not self.dofs:
            raise StructureError("the supports hold every degree of freedom", field="supports")
        for mass in self.masses:
            self._check_known(mass.node, "masses")
        for spring in self.springs:
            self.index(spring.dof)
        self._check_joints()

    def _check_known(self, node: int, name: str) -> None:
        if node not in self.nodes:
            raise StructureError(f"there is no node {node}", field=name, value=node)

    def _check_nodes(self) -> None:
        n_axes = 3 if self.blocks else 2
        for number, place in self.nodes.items():
            if number < 1 or len(place) != n_axes or not np.abs(place).max() <= INPUT.max_coordinate:
                allowed = bounds(-INPUT.max_coordinate, INPUT.max_coordinate, unit="m")
                raise StructureError(
                    f"node {number} has no place",
                    field="nodes",
                    value=place,
                    allowed=allowed,
                )
        for support in self.supports:
            self._check_known(support.node, "supports")
            for direction in support.directions:
                if direction not in DIRECTIONS:
                    raise StructureError(
                        f"no direction {direction!r}",
                        field="supports",
                        value=direction,
                        allowed=list(DIRECTIONS),
                    )

    def _check_members(self) -> None:
        if not self.all_members:
            raise StructureError("a structure needs members", field="members", value=0, allowed=bounds(1))
        numbers = [member.number for member in self.all_members]
        if len(set(numbers)) < len(numbers):
            raise StructureError("two members share a number", field="members")
        for member in self.all_members:
            for node in member.nodes:
                self._check_known(node, "members")
            if isinstance(member, MatrixElement):
                self._check_block(member)
            elif isinstance(member, Plate):
                member.check_corners([self.nodes[n] for n in member.nodes])
            elif self.length(member) < INPUT.min_length:
                raise StructureError(f"member {member.number} has no length", field="members", value=0.0)
        position = {node: i for i, node in enumerate(self.nodes)}
        ends = [(position[a], position[b]) for member in self.all_members for a, b in pairwise(member.nodes)]
        rows, columns = np.array(ends, int).reshape(-1, 2).T
        graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(len(position),) * 2)
        parts, label = connected_components(graph, directed=False)
        if parts > 1:
            loose = [node for node, i in position.items() if label[i] != label[0]]
            raise StructureError(
                f"the structure falls into {parts} parts that nothing joins",
                field="members",
                value=loose[:8],
                allowed="one connected structure",
            )

    def _check_joints(self) -> None:
        nodes = [joint.node for joint in self.joints]
        for node in nodes:
            self.index(Dof(node, "RZ"))
            if nodes.count(node) > 1 or sum(node in member.nodes for member in self.members) < 2:
                raise StructureError(
                    f"there is no joint at node {node}, or two",
                    field="joints",
                    value=node,
                    allowed="a node where two bars meet, once",
                )

    def _check_block(self, member: MatrixElement) -> None:
        n_blocks = 0 if self.blocks is None else len(self.blocks.mass)
        if not 0 <= member.index < n_blocks:
            raise StructureError(
                f"member {member.number} has no matrices",
                field="members",
                value=member.index,
                allowed=bounds(0, n_blocks - 1),
            )

    def length(self, member: Member) -> float:
        """Return a bar's length, m."""
        (x1, y1), (x2, y2) = (self.nodes[n][:2] for n in member.nodes)
        return float(np.hypot(x2 - x1, y2 - y1))

    @cached_property
    def dofs(self) -> tuple[Dof, ...]:
        """Free degrees of freedom, node by node, in the order of `directions`, or in that of `blocks`."""
        fixed = {(s.node, d) for s in self.supports for d in s.directions}
        if self.blocks:
            return tuple(dof for dof in self.blocks.dofs if (dof.node, dof.direction) not in fixed)
        return tuple(Dof(n, d) for n in self.nodes for d in self.directions if (n, d) not in fixed)

    @cached_property
    def held_dofs(self) -> tuple[Dof, ...]:
        """Degrees of freedom that the supports hold, in the order of the supports."""
        held = dict.fromkeys(Dof(s.node, d) for s in self.supports for d in s.directions)
        if self.blocks and held:
            possible = set(self.blocks.dofs)
            return tuple(dof for dof in held if dof in possible)
        return tuple(dof for dof in held if dof.direction in self.directions)

    @cached_property
    def _index(self) -> dict[Dof, int]:
        return {dof: i for i, dof in enumerate(self.dofs)}

    def index(self, dof: Dof) -> int:
        """Return the row of a DoF in every matrix of the structure.

        Raises
        ------
        UnknownDofError
            If the structure has no such DoF, or it is fixed.
        """
        try:
            return self._index[dof.point]
        except KeyError:
            at_node = [str(free) for free in self.dofs if free.node == dof.node]
            nodes = {"nodes": bounds(min(self.nodes), max(self.nodes))}
            allowed = at_node if dof.node in self.nodes else nodes
            raise UnknownDofError(
                f"the structure has no degree of freedom {dof}",
                field="dof",
                value=str(dof),
                allowed=allowed,
            ) from None

    @cached_property
    def all_members(self) -> tuple[AnyMember, ...]:
        """Bars, then other members: the order of all arrays by member."""
        return (*self.members, *self.non_bar_members)

    def of_members(self, members: Iterable[AnyMember]) -> "Structure":
        """Return the structure with all members replaced."""
        all_members = tuple(members)
        bars = tuple(member for member in all_members if isinstance(member, Member))
        other_members = tuple(member for member in all_members if not isinstance(member, Member))
        return replace(self, members=bars, non_bar_members=other_members)

    @cached_property
    def groups(self) -> Mapping[str, tuple[int, ...]]:
        """Members by number under the names of their groups."""
        numbers_of: dict[str, list[int]] = {}
        for member in self.all_members:
            if member.group:
                numbers_of.setdefault(member.group, []).append(member.number)
        return {name: tuple(numbers) for name, numbers in numbers_of.items()}

    @cached_property
    def _by_number(self) -> dict[int, AnyMember]:
        return {member.number: member for member in self.all_members}

    def member(self, number: int) -> AnyMember:
        """Return the member of that number.

        Raises
        ------
        InvalidInputError
            If there is none.
        """
        try:
            return self._by_number[number]
        except KeyError:
            raise InvalidInputError(
                f"there is no member {number}",
                field="members",
                value=number,
                allowed=[member.number for member in self.all_members[:100]],
            ) from None
