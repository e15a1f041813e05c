"""Wire types of structures."""

from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import Field

from modallab.api.limits import REQUEST
from modallab.api.names import CatalogueName
from modallab.api.schema import NamedByPattern
from modallab.api.structures.damping import DampingOrWord, StructuralIn
from modallab.api.structures.parts import (
    GroundSpringIn,
    MaterialIn,
    MemberIn,
    PointMassIn,
    SectionIn,
    SupportIn,
)
from modallab.api.wire import NO_CONVERSION, Effects, Number, Positive, Text, Wire
from modallab.core.dof import Dof
from modallab.core.errors import StructureError, bounds
from modallab.fe.beam import beam
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.plate import Edge, Holding, plate
from modallab.fe.structure import GroundSpringElement, Member, PointMass, Structure, Support

ElementCount = Annotated[int, Field(ge=1, le=REQUEST.described_items), NO_CONVERSION]


class _Described(Wire):
    damping: DampingOrWord = StructuralIn(law="structural")
    """damping law; `unknown` for short of that law; left out: undamped"""
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
    sections: Annotated[dict[Text, SectionIn], NamedByPattern()] = Field(max_length=REQUEST.described_items)
    """cross-sections by name"""
    materials: Annotated[dict[Text, MaterialIn], NamedByPattern()] = Field(max_length=REQUEST.described_items)
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
