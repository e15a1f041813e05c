"""Wire types of a mesh's description."""

from typing import Annotated

from pydantic import Field, TypeAdapter, ValidationError

from modallab.api.faults import wrong_json
from modallab.api.limits import REQUEST
from modallab.api.schema import NamedByPattern
from modallab.api.structures.parts import Directions, MaterialIn, SectionIn
from modallab.api.wire import Number, Positive, Text, Wire
from modallab.interchange.mesh.description import HeldGroup, MeshBar, MeshDescription, MeshPlate


class LineSectionIn(SectionIn):
    """A cross-section of lines; what is left out of bars in space is that of a round one."""

    second_moment_across: Number | None = Field(
        default=None, description="m^4, across the plane of `upright`"
    )
    torsion: Number | None = Field(default=None, description="m^4; left out: the sum of both second moments")
    upright: tuple[Number, Number, Number] | None = Field(
        default=None,
        description="spans with the bar the plane of `second_moment`; left out: Z, of bars along Z Y",
    )


class BarsIn(Wire):
    """Lines as bars."""

    material: MaterialIn
    """material of the bars"""
    section: LineSectionIn
    """cross-section of the bars"""

    def to_domain(self) -> MeshBar:
        """Return material and section of the bars."""
        section = self.section
        return MeshBar(
            self.material.to_domain(),
            section.to_domain(),
            section.second_moment_across,
            section.torsion,
            section.upright,
        )


class PlatesIn(Wire):
    """Triangles and quadrilaterals as plates."""

    material: MaterialIn
    """material of the plates"""
    thickness: Positive
    """m, thickness"""

    def to_domain(self) -> MeshPlate:
        """Return material and thickness of the plates."""
        return MeshPlate(self.material.to_domain(), self.thickness)


class HeldIn(Wire):
    """Directions in which the points of a group are held."""

    group: Text
    """name of the group of points"""
    directions: Directions
    """directions held"""


class MeshIn(Wire):
    """Properties that a mesh file does not contain, by the names of its groups."""

    groups: Annotated[dict[Text, BarsIn | PlatesIn], NamedByPattern()] = Field(
        min_length=1, max_length=REQUEST.mesh_groups
    )
    supports: list[HeldIn] = Field([], max_length=REQUEST.mesh_groups)
    left_out: list[Text] = Field(
        [],
        max_length=REQUEST.mesh_groups,
        description="groups, or types of cells as `line`, that become no members",
    )
    length_unit: Number = Field(default=1.0, description="m; 0.001 of a mesh in mm")

    def to_domain(self) -> MeshDescription:
        """Return the description."""
        return MeshDescription(
            {name: group.to_domain() for name, group in self.groups.items()},
            tuple(HeldGroup(group.group, tuple(group.directions)) for group in self.supports),
            tuple(self.left_out),
            self.length_unit,
        )


def mesh_of(text: str) -> MeshDescription:
    """Return the description that a form field holds as JSON.

    Raises
    ------
    InvalidInputError
        If it is no JSON, or describes no mesh.
    """
    try:
        return MeshIn.model_validate_json(text).to_domain()
    except ValidationError as error:
        raise wrong_json(error, TypeAdapter(MeshIn), text, "mesh") from None
