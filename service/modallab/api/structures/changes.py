"""Wire types of changes to a structure."""

from typing import Annotated, Literal

from pydantic import Field

from modallab.api.wire import DofText, NodeNumber, NonNegative, Positive, Wire
from modallab.core.dof import Dof
from modallab.fe.changes import (
    Change,
    GroundStiffness,
    JointStiffness,
    MemberChange,
    MemberProperty,
    NodeMass,
)


class MemberChangeIn(Wire):
    """A property of some members, multiplied by `factor` or set to `value`."""

    members: list[NodeNumber] = Field(min_length=1, max_length=5000)
    """numbers of the members"""
    property: MemberProperty
    """property that is changed"""
    factor: NonNegative | None = None
    """1, factor by which the property is multiplied; give this or `value`"""
    value: NonNegative | None = None
    """value that the property is set to, in its SI unit"""

    def to_domain(self) -> Change:
        """Return the change."""
        return MemberChange(tuple(self.members), self.property, self.factor, self.value)


class NodeMassIn(Wire):
    """The mass, kg, that a node carries beside its members."""

    node: NodeNumber
    """number of the node"""
    property: Literal["mass"]
    """`mass`"""
    value: NonNegative
    """kg, mass at the node"""

    def to_domain(self) -> Change:
        """Return the change."""
        return NodeMass(self.node, self.value)


class GroundStiffnessIn(Wire):
    """The spring, N/m or N m, between a DoF and the ground."""

    dof: DofText
    """degree of freedom that the spring holds"""
    property: Literal["ground_stiffness"]
    """`ground_stiffness`"""
    value: NonNegative
    """N/m, or N m/rad of a rotation: stiffness"""

    def to_domain(self) -> Change:
        """Return the change."""
        return GroundStiffness(Dof.parse(self.dof), self.value)


class JointStiffnessIn(Wire):
    """The rotational spring, N m/rad, between two sides of a node where bars meet."""

    node: NodeNumber
    """number of the node"""
    property: Literal["joint_stiffness"]
    """`joint_stiffness`"""
    value: Positive
    """N m/rad, stiffness between the two sides"""

    def to_domain(self) -> Change:
        """Return the change."""
        return JointStiffness(self.node, self.value)


ChangeIn = MemberChangeIn | NodeMassIn | GroundStiffnessIn | JointStiffnessIn


class ChangesIn(Wire):
    """Changes, made in their order."""

    changes: Annotated[list[ChangeIn], Field(min_length=1, max_length=1000)]
    """changes, made one after the other"""
