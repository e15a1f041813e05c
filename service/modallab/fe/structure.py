"""A structure as an analyst describes it; checked once, when it is made."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from modallab.core.dof import DIRECTIONS, Dof
from modallab.core.errors import InvalidInputError, StructureError, UnknownDofError
from modallab.core.place import EffectSpec
from modallab.fe.damping import Damping, StructuralDamping

PLANE = ("X", "Y", "RZ")


# No beam is outside of these, and products of what is inside neither vanish nor overflow.
SMALLEST, LARGEST = 1e-30, 1e30
FARTHEST = 1e9  # m


def positive(value: float, name: str) -> None:
    """Raise `StructureError` unless the value is above zero and of a size that can be computed with."""
    if not SMALLEST <= value <= LARGEST:  # NaN fails too
        allowed = f"{SMALLEST:g} to {LARGEST:g}"
        raise StructureError(f"{name} must be positive", field=name, value=value, allowed=allowed)


def not_negative(value: float, name: str) -> None:
    """Raise `StructureError` if the value is below zero or of a size that cannot be computed with."""
    if not 0 <= value <= LARGEST:
        allowed = f"0 to {LARGEST:g}"
        raise StructureError(f"{name} must not be negative", field=name, value=value, allowed=allowed)


def within(value: float, lowest: float, highest: float, name: str) -> None:
    """Raise `StructureError` unless the value lies between the bounds."""
    if not lowest <= value <= highest:
        allowed = f"{lowest:g} to {highest:g}"
        raise StructureError(f"{name} is out of bounds", field=name, value=value, allowed=allowed)


@dataclass(frozen=True)
class Section:
    """A cross-section."""

    area: float  # m^2
    second_moment: float  # m^4
    name: str = ""
    shear_coefficient: float = 5 / 6  # kappa, share of the area that shears; 5/6: a rectangle

    def __post_init__(self) -> None:
        positive(self.area, "area")
        positive(self.second_moment, "second_moment")
        within(self.shear_coefficient, 0.01, 1.0, "shear_coefficient")


@dataclass(frozen=True)
class Material:
    """An isotropic material."""

    modulus: float  # N/m^2
    density: float  # kg/m^3
    name: str = ""
    poisson_ratio: float = 0.3

    def __post_init__(self) -> None:
        positive(self.modulus, "modulus")
        positive(self.density, "density")
        within(self.poisson_ratio, -0.99, 0.5, "poisson_ratio")

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)), N/m^2."""
        return self.modulus / (2 * (1 + self.poisson_ratio))


@dataclass(frozen=True)
class Member:
    """One element; its factors multiply the matrices that section and material give."""

    number: int
    nodes: tuple[int, int]
    section: Section
    material: Material
    element: str = "frame"
    mass_factor: float = 1.0
    axial_factor: float = 1.0
    bending_factor: float = 1.0
    loss_factor: float | None = None  # of its own; None: the structure's damping law

    def __post_init__(self) -> None:
        for name in ("mass_factor", "axial_factor", "bending_factor"):
            positive(getattr(self, name), name)
        if self.loss_factor is not None:
            not_negative(self.loss_factor, "loss_factor")


@dataclass(frozen=True)
class Support:
    """Directions of a node that are held."""

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
class GroundSpring:
    """A spring between a DoF and the ground."""

    dof: Dof
    stiffness: float  # N/m, or N m for a rotation

    def __post_init__(self) -> None:
        not_negative(self.stiffness, "stiffness")


@dataclass(frozen=True, eq=False)
class Structure:
    """Nodes, members, what holds them and how they are damped.

    Raises
    ------
    StructureError
        If it cannot be analysed: unknown nodes, members of no length, parts that hang together
        with nothing, every DoF held.
    """

    nodes: Mapping[int, tuple[float, float]]  # m
    members: tuple[Member, ...]
    supports: tuple[Support, ...] = ()
    masses: tuple[PointMass, ...] = ()
    springs: tuple[GroundSpring, ...] = ()
    damping: Damping = field(default_factory=StructuralDamping)
    directions: tuple[str, ...] = PLANE  # that every node has, unless held
    effects: tuple[EffectSpec, ...] = ()
    name: str = ""

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

    def _check_known(self, node: int, name: str) -> None:
        if node not in self.nodes:
            raise StructureError(f"there is no node {node}", field=name, value=node)

    def _check_nodes(self) -> None:
        for number, place in self.nodes.items():
            if number < 1 or not np.abs(place).max() <= FARTHEST:
                allowed = f"within {FARTHEST:g} m"
                raise StructureError(
                    f"node {number} has no place", field="nodes", value=str(place), allowed=allowed
                )
        for support in self.supports:
            self._check_known(support.node, "supports")
            for direction in support.directions:
                if direction not in DIRECTIONS:
                    raise StructureError(
                        f"no direction {direction!r}",
                        field="supports",
                        value=direction,
                        allowed=", ".join(DIRECTIONS),
                    )

    def _check_members(self) -> None:
        if not self.members:
            raise StructureError("a structure needs members", field="members", value=0, allowed=">= 1")
        numbers = [member.number for member in self.members]
        if len(set(numbers)) < len(numbers):
            raise StructureError("two members share a number", field="members")
        for member in self.members:
            for node in member.nodes:
                self._check_known(node, "members")
            if self.length(member) < 1e-9:
                raise StructureError(f"member {member.number} has no length", field="members", value=0.0)
        position = {node: i for i, node in enumerate(self.nodes)}
        ends = np.array([[position[n] for n in member.nodes] for member in self.members])
        graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(len(position),) * 2)
        parts, label = connected_components(graph, directed=False)
        if parts > 1:
            loose = [node for node, i in position.items() if label[i] != label[0]]
            raise StructureError(
                f"the structure falls into {parts} parts that nothing joins",
                field="members",
                value=", ".join(map(str, loose[:8])),
                allowed="one connected structure",
            )

    def length(self, member: Member) -> float:
        """Return a member's length, m."""
        (x1, y1), (x2, y2) = (self.nodes[n] for n in member.nodes)
        return float(np.hypot(x2 - x1, y2 - y1))

    @cached_property
    def dofs(self) -> tuple[Dof, ...]:
        """Free degrees of freedom, node by node, in the order of `directions`."""
        held = {(s.node, d) for s in self.supports for d in s.directions}
        return tuple(Dof(n, d) for n in self.nodes for d in self.directions if (n, d) not in held)

    @cached_property
    def _index(self) -> dict[Dof, int]:
        return {dof: i for i, dof in enumerate(self.dofs)}

    def index(self, dof: Dof) -> int:
        """Return the row of a DoF in every matrix of the structure.

        Raises
        ------
        UnknownDofError
            If the structure has no such DoF, or holds it.
        """
        try:
            return self._index[dof.point]
        except KeyError:
            if dof.node in self.nodes:
                has = ", ".join(str(d) for d in self.dofs if d.node == dof.node) or "none: it is held"
            else:
                has = f"nodes {min(self.nodes)} to {max(self.nodes)}"
            raise UnknownDofError(
                f"the structure has no degree of freedom {dof}", field="dof", value=str(dof), allowed=has
            ) from None

    def member(self, number: int) -> Member:
        """Return the member of that number.

        Raises
        ------
        InvalidInputError
            If there is none.
        """
        for member in self.members:
            if member.number == number:
                return member
        raise InvalidInputError(
            f"there is no member {number}",
            field="members",
            value=number,
            allowed=", ".join(str(m.number) for m in self.members[:100]),
        )
