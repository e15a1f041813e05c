"""Wire types of the parts of a structure."""

from typing import Annotated, Literal

from pydantic import Field

from modallab.api.schema import Limits
from modallab.api.wire import Count, DofText, NodeNumber, NonNegative, Number, Positive, Text, Wire
from modallab.fe.structure import Material, Section
from modallab.fe.structure_settings import INPUT

ShearCoefficient = Annotated[Number, Limits(INPUT.min_shear_coefficient, INPUT.max_shear_coefficient)]


class SectionIn(Wire):
    """A cross-section: m^2, m^4, and the share of the area that shears."""

    area: Positive
    """m^2, area"""
    second_moment: Positive
    """m^4, second moment of area"""
    shear_coefficient: ShearCoefficient = 5 / 6
    """1, share of the area that carries shear"""

    def to_domain(self, name: str = "") -> Section:
        """Return the section."""
        return Section(self.area, self.second_moment, name, self.shear_coefficient)


class MaterialIn(Wire):
    """A material: N/m^2, kg/m^3."""

    modulus: Positive
    """N/m^2, modulus of elasticity"""
    density: Positive
    """kg/m^3, density"""
    poisson_ratio: Annotated[Number, Limits(INPUT.min_poisson_ratio, INPUT.max_poisson_ratio)] = 0.3
    """1, Poisson ratio"""

    def to_domain(self, name: str = "") -> Material:
        """Return the material."""
        return Material(self.modulus, self.density, name, self.poisson_ratio)


Directions = Annotated[list[Literal["X", "Y", "Z", "RX", "RY", "RZ"]], Field(min_length=1, max_length=6)]


class SupportIn(Wire):
    """Directions of a node that are held."""

    node: NodeNumber
    """number of the node"""
    directions: Directions
    """directions held"""


class PointMassIn(Wire):
    """A mass, kg, at a node."""

    node: NodeNumber
    """number of the node"""
    mass: NonNegative
    """kg, mass"""


class GroundSpringIn(Wire):
    """A spring from a DoF to the ground: N/m, or N m for a rotation."""

    dof: DofText
    """degree of freedom that the spring holds"""
    stiffness: NonNegative
    """N/m, or N m/rad of a rotation"""


class MemberIn(Wire):
    """A member between two nodes, of a named section and material."""

    number: NodeNumber
    """number of the member"""
    nodes: tuple[Count, Count]
    """numbers of its two nodes"""
    section: Text
    """name of its section"""
    material: Text
    """name of its material"""
