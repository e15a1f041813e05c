"""Wire types of changes to a structure."""

from typing import Annotated, Literal

from pydantic import Field

from modallab.api.wire import Count, DofText, Number, Wire
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

    members: list[Count] = Field(min_length=1, max_length=5000)
    property: MemberProperty
    factor: Number | None = None
    value: Number | None = None

    def to_domain(self) -> Change:
        """Return the change."""
        return MemberChange(tuple(self.members), self.property, self.factor, self.value)


class NodeMassIn(Wire):
    """The mass, kg, that a node carries beside its members."""

    node: Count
    property: Literal["mass"]
    value: Number

    def to_domain(self) -> Change:
        """Return the change."""
        return NodeMass(self.node, self.value)


class GroundStiffnessIn(Wire):
    """The spring, N/m or N m, between a DoF and the ground."""

    dof: DofText
    property: Literal["ground_stiffness"]
    value: Number

    def to_domain(self) -> Change:
        """Return the change."""
        return GroundStiffness(Dof.parse(self.dof), self.value)


class JointStiffnessIn(Wire):
    """The rotational spring, N m/rad, between two sides of a node where bars meet."""

    node: Count
    property: Literal["joint_stiffness"]
    value: Number

    def to_domain(self) -> Change:
        """Return the change."""
        return JointStiffness(self.node, self.value)


ChangeIn = MemberChangeIn | NodeMassIn | GroundStiffnessIn | JointStiffnessIn


class ChangesIn(Wire):
    """Changes, made in their order."""

    changes: Annotated[list[ChangeIn], Field(min_length=1, max_length=1000)]
