"""Wire types of structures."""

from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import Field, TypeAdapter, ValidationError

from modallab.api.faults import wrong_json
from modallab.api.limits import REQUEST
from modallab.api.names import CatalogueName
from modallab.api.schema import Limits, NamedByPattern
from modallab.api.wire import (
    NO_CONVERSION,
    Count,
    DofText,
    Effects,
    NodeNumber,
    NonNegative,
    Number,
    Positive,
    Text,
    Wire,
)
from modallab.core.dof import Dof
from modallab.core.errors import StructureError, bounds
from modallab.fe.beam import beam
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import Damping, ModalDamping, StructuralDamping, ViscousDamping
from modallab.fe.plate import Edge, Holding, plate
from modallab.fe.settings import INPUT
from modallab.fe.structure import (
    GroundSpringElement,
    Material,
    Member,
    PointMass,
    Section,
    Structure,
    Support,
)

ElementCount = Annotated[int, Field(ge=1, le=REQUEST.described_items), NO_CONVERSION]


ShearCoefficient = Annotated[Number, Limits(INPUT.min_shear_coefficient, INPUT.max_shear_coefficient)]


class SectionIn(Wire):
    """A cross-section: m^2, m^4, and the share of the area that shears."""

    area: Positive
    """m^2, area"""
    second_moment: Positive
    """m^4, second moment of area"""
    shear_coefficient: Annotated[Number, Limits(INPUT.min_shear_coefficient, INPUT.max_shear_coefficient)] = (
        5 / 6
    )
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


DampingCoefficient = Annotated[Number, Limits(0.0, INPUT.max_damping)]


class StructuralIn(Wire):
    """D = a M + b K."""

    law: Literal["structural"]
    """`structural`: hysteretic damping"""
    stiffness_coefficient: DampingCoefficient = 0.0
    """1, b of D = a M + b K"""
    mass_coefficient: DampingCoefficient = 0.0
    """(rad/s)^2, a of D = a M + b K"""

    def to_domain(self) -> Damping:
        """Return the damping law."""
        return StructuralDamping(self.stiffness_coefficient, self.mass_coefficient)


class ViscousIn(Wire):
    """C = a M + b K."""

    law: Literal["viscous"]
    """`viscous`: proportional viscous damping"""
    stiffness_coefficient: DampingCoefficient = 0.0
    """s, b of C = a M + b K"""
    mass_coefficient: DampingCoefficient = 0.0
    """1/s, a of C = a M + b K"""

    def to_domain(self) -> Damping:
        """Return the damping law."""
        return ViscousDamping(self.stiffness_coefficient, self.mass_coefficient)


Ratios = DampingCoefficient | Annotated[list[DampingCoefficient], Field(min_length=1, max_length=1000)]


class ModalIn(Wire):
    """Loss factors or damping ratios of the elastic modes: one for all, or a list from the lowest."""

    law: Literal["modal"]
    """`modal`: damping mode by mode"""
    loss_factors: Ratios | None = None
    """1, loss factors, one for all elastic modes or a list from the lowest; give these or `damping_ratios`"""
    damping_ratios: Ratios | None = None
    """1, viscous damping ratios, one for all elastic modes or a list from the lowest"""

    def to_domain(self) -> Damping:
        """Return the damping law."""
        if (self.loss_factors is None) == (self.damping_ratios is None):
            raise StructureError(
                "modal damping takes loss factors or damping ratios",
                field="damping",
                allowed="one of loss_factors, damping_ratios",
            )
        given, scale = (self.damping_ratios, 2.0) if self.loss_factors is None else (self.loss_factors, 1.0)
        values = given if isinstance(given, list) else [given]
        return ModalDamping(tuple(scale * value for value in values if value is not None))


DampingIn = Annotated[StructuralIn | ViscousIn | ModalIn, Field(discriminator="law")]


def damping_of(text: str) -> Damping:
    """Return the damping law that a form's field writes as JSON.

    Raises
    ------
    InvalidInputError
        If it is none.
    """
    adapter: TypeAdapter[StructuralIn | ViscousIn | ModalIn] = TypeAdapter(DampingIn)
    try:
        return adapter.validate_json(text).to_domain()
    except ValidationError as error:
        raise wrong_json(error, adapter, text, "damping") from None


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


class _Described(Wire):
    damping: DampingIn = StructuralIn(law="structural")
    """damping law; left out: undamped"""
    supports: list[SupportIn] = Field([], max_length=REQUEST.described_items)
    """supports, none if left out"""
    masses: list[PointMassIn] = Field([], max_length=REQUEST.described_items)
    """point masses"""
    springs: list[GroundSpringIn] = Field([], max_length=REQUEST.described_items)
    """springs to the ground"""
    effects: Effects = ()
    """effects that the structure has beside its elements"""
    name: Text = ""
    """name of the structure, free text"""

    def _common(self) -> dict[str, Any]:
        return {
            "damping": self.damping.to_domain(),
            "supports": tuple(Support(s.node, tuple(s.directions)) for s in self.supports),
            "masses": tuple(PointMass(m.node, m.mass) for m in self.masses),
            "springs": tuple(GroundSpringElement(Dof.parse(s.dof), s.stiffness) for s in self.springs),
            "name": self.name,
        }

    def _with_effects(self, plain: Structure) -> Structure:
        effects = [effect.to_domain() for effect in self.effects]
        for effect in effects:
            effect.check(plain)
        return replace(plain, effects=tuple(effect.spec for effect in effects))


class _OfBars(_Described):
    theory: Literal["bernoulli_euler", "timoshenko"] = "bernoulli_euler"
    """beam theory of the elements"""

    @property
    def _element(self) -> str:
        return "timoshenko" if self.theory == "timoshenko" else "frame"


class BeamIn(_OfBars):
    """A straight beam along X in bending, nodes 1 to n + 1."""

    kind: Literal["beam"]
    """`beam`"""
    length: Positive
    """m, length"""
    n_elements: ElementCount
    """number of elements"""
    section: SectionIn
    """cross-section"""
    material: MaterialIn
    """material"""

    def to_domain(self) -> Structure:
        """Return the structure."""
        section, material = self.section.to_domain(), self.material.to_domain()
        plain = beam(
            length=self.length,
            n_elements=self.n_elements,
            section=section,
            material=material,
            element=self._element,
            **self._common(),
        )
        return self._with_effects(plain)


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


class PlateIn(_Described):
    """A flat rectangular plate in X and Y, moving along Z; nodes row by row from 0, 0."""

    kind: Literal["plate"]
    """`plate`"""
    length: Positive
    """m, along X"""
    width: Positive
    """m, along Y"""
    thickness: Positive
    """m, thickness"""
    n_elements: tuple[ElementCount, ElementCount] = Field(description="along X and along Y")
    material: MaterialIn
    """material"""
    edges: dict[Edge, Holding] = Field({}, description="how sides are held; free where left out")

    def to_domain(self) -> Structure:
        """Return the structure."""
        along, across = self.n_elements
        if along * across > REQUEST.plate_elements:
            raise StructureError(
                "too many elements",
                field="n_elements",
                value=along * across,
                allowed=bounds(maximum=REQUEST.plate_elements),
            )
        plain = plate(
            length=self.length,
            width=self.width,
            thickness=self.thickness,
            n_elements=self.n_elements,
            material=self.material.to_domain(),
            edges=self.edges,
            **self._common(),
        )
        return self._with_effects(plain)


Coordinates = tuple[Number, Number]
NodeKey = Annotated[str, Field(pattern=r"^[1-9][0-9]{0,8}$")]


class FrameIn(_OfBars):
    """A plane frame in X and Y."""

    kind: Literal["frame"]
    """`frame`"""
    nodes: Annotated[dict[NodeKey, Coordinates], NamedByPattern()] = Field(max_length=REQUEST.described_items)
    """m, X and Y of each node by its number"""
    sections: dict[Text, SectionIn] = Field(max_length=REQUEST.described_items)
    """cross-sections by name"""
    materials: dict[Text, MaterialIn] = Field(max_length=REQUEST.described_items)
    """materials by name"""
    members: list[MemberIn] = Field(max_length=REQUEST.described_items)
    """bars between the nodes"""

    def to_domain(self) -> Structure:
        """Return the structure."""
        sections = {name: part.to_domain(name) for name, part in self.sections.items()}
        materials = {name: part.to_domain(name) for name, part in self.materials.items()}
        members = tuple(
            Member(
                m.number,
                m.nodes,
                _part(sections, m.section, "section"),
                _part(materials, m.material, "material"),
                self._element,
            )
            for m in self.members
        )
        nodes = {int(number): place for number, place in self.nodes.items()}
        return self._with_effects(Structure(nodes=nodes, members=members, **self._common()))


def _part(parts: dict[str, Any], name: str, kind_name: str) -> Any:
    if name not in parts:
        raise StructureError(
            f"there is no {kind_name} {name!r}", field=f"members.{kind_name}", value=name, allowed=list(parts)
        )
    return parts[name]


class CatalogueIn(Wire):
    """A ready structure by name; `GET /v1/catalog/structures` lists them."""

    kind: Literal["catalogue"]
    """`catalogue`"""
    name: CatalogueName
    """name of a ready structure"""

    def to_domain(self) -> Structure:
        """Return the structure."""
        return STRUCTURES[self.name]()


StructureIn = Annotated[BeamIn | FrameIn | PlateIn | CatalogueIn, Field(discriminator="kind")]
