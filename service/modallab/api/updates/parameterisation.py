"""Wire types of the parameters that an update may change."""

from typing import Annotated, Literal

from pydantic import Field

from modallab.api.schema import NamedByPattern
from modallab.api.wire import NO_CONVERSION, Count, Number, Text, Wire
from modallab.fe.structure import Structure
from modallab.updating.method_options import parts_of
from modallab.updating.parameterisation import (
    Parameterisation,
    Part,
    at_nodes,
    check_no_loss_factors,
    parameterise,
)
from modallab.updating.partitioning import (
    Groups,
    automatic_groups,
    named_groups,
    partitioned,
    property_groups,
)

Group = Annotated[list[Count], Field(min_length=1, max_length=5000)] | Text  # numbers, or a group's name


class GroupsIn(Wire):
    """Macro elements by properties of members: named groups, and sections or thicknesses with a material."""

    by: Literal["groups"]
    """`groups`: one macro element for each group"""

    def groups(self, structure: Structure) -> Groups:
        """Return the members of each."""
        return property_groups(structure)


class PartitionIn(Wire):
    """Macro elements that are connected parts of the structure, of about as many members each."""

    by: Literal["partition"]
    """`partition`: connected parts of equal size"""
    count: Annotated[int, Field(ge=1, le=1000), NO_CONVERSION] | None = Field(
        default=None,
        description="macro elements; left out: a quarter of the members, 60 at most",
    )

    def groups(self, structure: Structure) -> Groups:
        """Return the members of each; `InvalidInputError` if there are fewer members."""
        return partitioned(structure, self.count)


Divided = Annotated[GroupsIn | PartitionIn, Field(discriminator="by")]
Listed = Annotated[list[Group], Field(min_length=1, max_length=1000)]
Macros = Literal["auto", "each"] | Divided | Listed
Parts = Annotated[list[Text], Field(max_length=len(Part))] | None
NodeGroups = Annotated[
    list[Annotated[list[Count], Field(min_length=1, max_length=5000)]],
    Field(min_length=1, max_length=1000),
]


class ParameterisationIn(Wire):
    """Which coefficients may move: members in groups, parts of their matrices, bounds; 1 = no change.

    The coefficient of a property, such as a thickness, is a multiple of its value in the model. A coefficient
    of damping is the loss factor added to a member's own: 0 = no change, bounds -1 and 2.
    """

    macros: Macros = Field(
        default="auto",
        description="lists of members or names of groups, `auto`, `each` member by itself, "
        "or a rule by which members are divided",
    )
    parts: Parts = Field(
        default=None,
        description="mass, stiffness, axial, bending, damping; or properties: density, modulus, area and "
        "second_moment of bars, thickness of plates; left out: mass and stiffness, of a method of complex "
        "modes damping too; none, with an empty list",
    )
    attached: Annotated[dict[Text, Literal["each"] | NodeGroups], NamedByPattern()] = Field(
        default={},
        max_length=len(Part),
        description="what nodes carry beside their members, by nodes: point_mass, ground_spring_x to "
        "ground_spring_rz, and joint_stiffness; lists of nodes, or `each` that carries one",
    )
    lower: Number = 0.05
    """1, lower bound of every coefficient"""
    upper: Number = 10.0
    """1, upper bound of every coefficient"""

    def to_domain(self, structure: Structure, method: str) -> Parameterisation:
        """Return the parameterisation; `InvalidInputError` where structure or method have none such."""
        if self.macros == "auto":
            groups = automatic_groups(structure)
        elif self.macros == "each":
            groups = tuple((member.number,) for member in structure.all_members)
        elif isinstance(self.macros, GroupsIn | PartitionIn):
            groups = self.macros.groups(structure)
        else:
            groups = tuple(tuple(group) for group in named_groups(structure, self.macros))
        usual = parts_of(method)
        parts = usual if self.parts is None else self.parts
        nodes = {
            name: None if nodes_or_each == "each" else nodes_or_each
            for name, nodes_or_each in self.attached.items()
        }
        also = at_nodes(structure, nodes)
        chosen = parameterise(groups, parts, lower=self.lower, upper=self.upper, nodal=also)
        chosen.groups(structure)
        if Part.DAMPING not in usual:
            check_no_loss_factors(chosen)
        return chosen
