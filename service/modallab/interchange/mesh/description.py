"""What a mesh does not say: what its cells are made of, and where they are held."""

from collections.abc import Mapping
from dataclasses import dataclass

from modallab.fe.members import Material, Section, positive


@dataclass(frozen=True)
class MeshBar:
    """What lines are made of; what is left out is that of a round bar.

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
    """What triangles and quadrilaterals are made of."""

    material: Material
    thickness: float  # m

    def __post_init__(self) -> None:
        positive(self.thickness, "thickness")


CellProperty = MeshBar | MeshPlate
CELL_TYPES: Mapping[type, tuple[str, ...]] = {MeshBar: ("line",), MeshPlate: ("triangle", "quad")}


@dataclass(frozen=True)
class HeldGroup:
    """Directions in which the points of a group are held."""

    group: str
    directions: tuple[str, ...]


@dataclass(frozen=True)
class MeshDescription:
    """What a mesh does not say: what its groups are made of, and the rest of what it takes."""

    groups: Mapping[str, CellProperty]
    supports: tuple[HeldGroup, ...] = ()
    left_out: tuple[str, ...] = ()  # groups, or types of cells
    length_unit: float = 1.0  # m

    def __post_init__(self) -> None:
        positive(self.length_unit, "length_unit")
