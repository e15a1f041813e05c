"""Description of a mesh by the caller: sections, materials, supports."""

from collections.abc import Mapping
from dataclasses import dataclass

from modallab.fe.members import Material, Section, positive


@dataclass(frozen=True)
class MeshBar:
    """Section and material of line cells; omitted constants are those of a round bar.

    In space bars bend by `section.second_moment` in the plane of their axis and `upright`, and across it by
    `second_moment_across`.
    """

    material: Material
    section: Section
    second_moment_across: float | None = None  # m^4; None: as the section's
    torsion: float | None = None  # m^4; None: the sum of both second moments
    upright: tuple[float, float, float] | None = None  # None: Z, of bars along Z: Y

    def __post_init__(self) -> None:
        for name in ("second_moment_across", "torsion"):
            if getattr(self, name) is not None:
                positive(getattr(self, name), name)


@dataclass(frozen=True)
class MeshPlate:
    """Thickness and material of triangles and quadrilaterals."""

    material: Material
    thickness: float  # m

    def __post_init__(self) -> None:
        positive(self.thickness, "thickness")


CellProperty = MeshBar | MeshPlate
CELL_TYPES: Mapping[type, tuple[str, ...]] = {MeshBar: ("line",), MeshPlate: ("triangle", "quad")}


@dataclass(frozen=True)
class HeldGroup:
    """Supports: constrained directions of the points of a group."""

    group: str
    directions: tuple[str, ...]


@dataclass(frozen=True)
class MeshDescription:
    """Sections and materials of the groups of a mesh, supports, ignored groups, unit of length."""

    groups: Mapping[str, CellProperty]
    supports: tuple[HeldGroup, ...] = ()
    left_out: tuple[str, ...] = ()  # groups, or types of cells
    length_unit: float = 1.0  # m

    def __post_init__(self) -> None:
        positive(self.length_unit, "length_unit")
