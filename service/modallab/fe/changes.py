"""Changes of a structure: each makes a new structure, nothing is changed in place."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.fe.damping import StructuralDamping
from modallab.fe.members import AnyMember, MatrixElement, Member
from modallab.fe.section_size import SectionSize, resized, size
from modallab.fe.structure import GroundSpringElement, JointSpring, PointMass, Structure


class MemberProperty(StrEnum):
    """Property of a member that can be changed."""

    DENSITY = "density"  # the element's mass matrix, kg/m^3
    MODULUS = "modulus"  # its whole stiffness matrix, N/m^2
    AXIAL_STIFFNESS = "axial_stiffness"  # E A, N; of a plate E t, N/m
    BENDING_STIFFNESS = "bending_stiffness"  # E I, N m^2; of a plate E t^3 / 12 (1 - nu^2), N m
    LOSS_FACTOR = "loss_factor"  # eta of D = eta K
    AREA = "area"  # of a bar, m^2
    SECOND_MOMENT = "second_moment"  # of a bar, m^4
    THICKNESS = "thickness"  # of a plate, m


@dataclass(frozen=True)
class MemberChange:
    """One property of some members: multiplied by `factor` or set to `value`, one of the two."""

    members: tuple[int, ...]
    property: MemberProperty
    factor: float | None = None
    value: float | None = None  # in the property's unit

    def __post_init__(self) -> None:
        if self.property not in tuple(MemberProperty):
            raise InvalidInputError(
                f"members have no property {self.property!r}",
                field="property",
                value=self.property,
                allowed=list(MemberProperty),
            )
        if not self.members:
            raise InvalidInputError("a change names no member", field="members", value=0, allowed=bounds(1))
        if (self.factor is None) == (self.value is None):
            raise InvalidInputError(
                "a change multiplies by a factor or sets a value",
                field="factor",
                value="none given" if self.factor is None else "both given",
                allowed="either factor or value",
            )
        for name, number in (("factor", self.factor), ("value", self.value)):
            if number is not None:
                _check(number, name, zero_allowed=self.property == MemberProperty.LOSS_FACTOR)

    def of(self, nominal: float) -> float:
        """Return the changed value of a property: `value`, or `factor` times the nominal value."""
        if self.value is not None:
            return self.value
        assert self.factor is not None
        return self.factor * nominal


@dataclass(frozen=True)
class NodeMass:
    """The mass that a node carries beside its members; 0 takes it away."""

    node: int
    mass: float  # kg

    def __post_init__(self) -> None:
        _check(self.mass, "value", zero_allowed=True)


@dataclass(frozen=True)
class GroundStiffness:
    """The spring between a DoF and the ground; 0 takes it away."""

    dof: Dof
    stiffness: float  # N/m, or N m for a rotation

    def __post_init__(self) -> None:
        _check(self.stiffness, "value", zero_allowed=True)


@dataclass(frozen=True)
class JointStiffness:
    """The rotational spring between two sides of a node."""

    node: int
    stiffness: float  # N m/rad

    def __post_init__(self) -> None:
        _check(self.stiffness, "value", zero_allowed=False)


Change = MemberChange | NodeMass | GroundStiffness | JointStiffness


def _check(number: float, field: str, *, zero_allowed: bool) -> None:
    if not np.isfinite(number) or number < 0 or (number == 0 and not zero_allowed):
        allowed = bounds(0) if zero_allowed else bounds(exclusive_minimum=0)
        raise InvalidInputError(f"{field} is out of bounds", field=field, value=number, allowed=allowed)


def change(structure: Structure, changes: Iterable[Change]) -> Structure:
    """Return a new structure with the changes made in their order.

    Raises
    ------
    InvalidInputError
        If a member, node or DoF is unknown, or a property cannot take the change.
    """
    for modification in changes:
        if isinstance(modification, MemberChange):
            structure = _with_members(structure, modification)
        elif isinstance(modification, NodeMass):
            structure = _with_mass(structure, modification)
        elif isinstance(modification, JointStiffness):
            joints = tuple(joint for joint in structure.joints if joint.node != modification.node)
            structure = replace(
                structure, joints=(*joints, JointSpring(modification.node, modification.stiffness))
            )
        else:
            structure = _with_spring(structure, modification)
    return structure


def _with_members(structure: Structure, modification: MemberChange) -> Structure:
    for number in modification.members:
        structure.member(number)  # raises for an unknown number
    numbers = set(modification.members)
    return structure.of_members(
        _changed(structure, member, modification) if member.number in numbers else member
        for member in structure.all_members
    )


def _changed(structure: Structure, member: AnyMember, modification: MemberChange) -> AnyMember:
    def changed_factor(factor: float) -> float:
        return (
            modification.of(factor)
            if modification.value is None
            else modification.value / _nominal(member, modification.property)
        )

    match modification.property:
        case MemberProperty.DENSITY:
            return replace(member, mass_factor=changed_factor(member.mass_factor))
        case MemberProperty.MODULUS:
            axial, bending = changed_factor(member.axial_factor), changed_factor(member.bending_factor)
            return replace(member, axial_factor=axial, bending_factor=bending)
        case MemberProperty.AXIAL_STIFFNESS:
            return replace(member, axial_factor=changed_factor(member.axial_factor))
        case MemberProperty.BENDING_STIFFNESS:
            return replace(member, bending_factor=changed_factor(member.bending_factor))
        case MemberProperty.LOSS_FACTOR:
            return replace(member, loss_factor=_loss_factor(structure, member, modification))
        case MemberProperty.AREA | MemberProperty.SECOND_MOMENT | MemberProperty.THICKNESS:
            shape = SectionSize(modification.property)
            return resized(member, shape, modification.of(size(member, shape)))


def _nominal(member: AnyMember, property: MemberProperty) -> float:
    """Return the nominal value of a property by section and material; for a plate E t, N/m, and D, N m."""
    if isinstance(member, MatrixElement):
        raise InvalidInputError(
            f"member {member.number} is given by its matrices, which have no {property}",
            field="value",
            value=property,
            allowed="a factor",
        )
    material = member.material
    if isinstance(member, Member):
        axial = material.modulus * member.section.area
        bending = material.modulus * member.section.second_moment
    else:
        axial = material.modulus * member.thickness
        bending = axial * member.thickness**2 / 12 / (1 - material.poisson_ratio**2)
    return {
        MemberProperty.DENSITY: material.density,
        MemberProperty.MODULUS: material.modulus,
        MemberProperty.AXIAL_STIFFNESS: axial,
        MemberProperty.BENDING_STIFFNESS: bending,
    }[property]


def _loss_factor(structure: Structure, member: AnyMember, modification: MemberChange) -> float:
    law, loss_factor = structure.damping, member.loss_factor
    if loss_factor is None and isinstance(law, StructuralDamping):
        loss_factor = law.stiffness_coefficient
    if loss_factor is None and modification.value is None:
        raise InvalidInputError(
            f"member {member.number} has no loss factor to multiply",
            field="factor",
            value=modification.of(1.0),
            allowed="a value: this damping law gives members no loss factor",
        )
    return modification.of(loss_factor or 0.0)


def _with_mass(structure: Structure, modification: NodeMass) -> Structure:
    if modification.node not in structure.nodes:
        raise InvalidInputError(
            f"there is no node {modification.node}",
            field="node",
            value=modification.node,
            allowed=bounds(min(structure.nodes), max(structure.nodes)),
        )
    masses = tuple(mass for mass in structure.masses if mass.node != modification.node)
    added = (PointMass(modification.node, modification.mass),) if modification.mass else ()
    return replace(structure, masses=masses + added)


def _with_spring(structure: Structure, modification: GroundStiffness) -> Structure:
    structure.index(modification.dof)
    springs = tuple(spring for spring in structure.springs if spring.dof.point != modification.dof.point)
    added = (
        (GroundSpringElement(modification.dof.point, modification.stiffness),)
        if modification.stiffness
        else ()
    )
    return replace(structure, springs=springs + added)
