"""Parts of an element that a coefficient multiplies, and which of them exclude one another."""

from enum import StrEnum

from modallab.core.errors import InvalidInputError
from modallab.fe.section_size import SectionSize


class Part(StrEnum):
    """Matrix of an element, or property that its matrices depend on, that a coefficient multiplies.

    A coefficient of damping is a loss factor added to that of the element; one of a node multiplies a mass,
    spring or joint there.
    """

    MASS = "mass"
    STIFFNESS = "stiffness"  # axial and bending together
    AXIAL = "axial"
    BENDING = "bending"
    DAMPING = "damping"  # eta of D_e = eta K_e, added to that of the element: 0 = no change
    DENSITY = "density"
    MODULUS = "modulus"
    AREA = "area"  # of a bar: mass and axial stiffness
    SECOND_MOMENT = "second_moment"  # of a bar: bending stiffness
    THICKNESS = "thickness"  # of a plate: mass and membrane stiffness by t, bending and rotary inertia by t^3

    POINT_MASS = "point_mass"  # of a node
    GROUND_SPRING_X = "ground_spring_x"  # between a node and the ground, in one direction
    GROUND_SPRING_Y = "ground_spring_y"
    GROUND_SPRING_Z = "ground_spring_z"
    GROUND_SPRING_RX = "ground_spring_rx"
    GROUND_SPRING_RY = "ground_spring_ry"
    GROUND_SPRING_RZ = "ground_spring_rz"

    JOINT_STIFFNESS = "joint_stiffness"  # of a joint at a node

    @property
    def label(self) -> str:
        """Name in words."""
        return f"ground spring {self.spring}" if self.spring else self.value.replace("_", " ")

    @property
    def is_nodal(self) -> bool:
        """True for parts of nodes, False for parts of members."""
        return self in (Part.POINT_MASS, Part.JOINT_STIFFNESS) or self.spring is not None

    @property
    def spring(self) -> str | None:
        """Direction of a ground spring, None for other parts."""
        prefix, _, direction = self.value.rpartition("_")
        return direction.upper() if prefix == "ground_spring" else None

    @property
    def is_property(self) -> bool:
        """True for a property of the member, False for a factor of its matrices and for parts of nodes."""
        return self in (Part.DENSITY, Part.MODULUS) or self.section_size is not None

    @property
    def section_size(self) -> SectionSize | None:
        """Size of the section, None for parts that are no size."""
        return SectionSize(self.value) if self.value in tuple(SectionSize) else None

    @property
    def matrices(self) -> tuple[str, ...]:
        """Matrices of an element that depend on the part."""
        return _MATRICES_BY_PART.get(self, (self.value,))

    @property
    def nominal(self) -> float:
        """Coefficient that leaves the model unchanged."""
        return 0.0 if self is Part.DAMPING else 1.0


_MATRICES_BY_PART = {
    Part.STIFFNESS: ("axial", "bending"),
    Part.DENSITY: ("mass",),
    Part.MODULUS: ("axial", "bending"),
    Part.AREA: ("mass", "axial"),
    Part.SECOND_MOMENT: ("bending",),
    Part.THICKNESS: ("mass", "axial", "bending"),
}


def check_part_overlap(number: int, part: Part, other_part: Part) -> None:
    """Raise `InvalidInputError` if a member cannot have coefficients of both parts.

    Two properties may share a matrix; other matrices distinguish them, or the identifiability shows that they
    cannot be separated.
    """
    common_matrix = next((matrix for matrix in part.matrices if matrix in other_part.matrices), None)
    if common_matrix is None or (part is not other_part and part.is_property and other_part.is_property):
        return
    clash = f"two coefficients of its {part.label}"
    if part is not other_part:
        clash = (
            f"coefficients of {other_part.label} and of {part.label}, "
            f"which both move its {common_matrix} matrix"
        )
    raise InvalidInputError(
        f"{'node' if part.is_nodal else 'member'} {number} has {clash}",
        field="macros",
        value=number,
        allowed="each member once for a part, and either its matrices or properties that move these",
    )
