"""What of an element a coefficient multiplies, and which of them go together."""

from enum import StrEnum

from modallab.core.errors import InvalidInputError
from modallab.fe.section_size import SectionSize


class Part(StrEnum):
    """What a coefficient multiplies: a matrix of an element, or a property that its matrices follow.

    Of damping, the loss factor added to an element's own; of nodes, what these carry beside their elements.
    """

    MASS = "mass"
    STIFFNESS = "stiffness"  # axial and bending together
    AXIAL = "axial"
    BENDING = "bending"
    DAMPING = "damping"  # eta of D_e = eta K_e, beside what the element has: 0 = no change
    DENSITY = "density"
    MODULUS = "modulus"
    AREA = "area"  # of a bar: mass and axial stiffness
    SECOND_MOMENT = "second_moment"  # of a bar: bending stiffness
    THICKNESS = "thickness"  # of a plate: mass and membrane by t, bending and turning normals by t^3

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
        """Its name as words."""
        return f"ground spring {self.spring}" if self.spring else self.value.replace("_", " ")

    @property
    def is_nodal(self) -> bool:
        """True of what nodes carry, False of what belongs to members."""
        return self in (Part.POINT_MASS, Part.JOINT_STIFFNESS) or self.spring is not None

    @property
    def spring(self) -> str | None:
        """Direction of the spring to ground that it is, None of all else."""
        prefix, _, direction = self.value.rpartition("_")
        return direction.upper() if prefix == "ground_spring" else None

    @property
    def is_property(self) -> bool:
        """True of a property of the member, False of what multiplies or joins its matrices."""
        return self in (Part.DENSITY, Part.MODULUS) or self.section_size is not None

    @property
    def section_size(self) -> SectionSize | None:
        """The size of the member that it is, None of what leaves section and thickness as they are."""
        return SectionSize(self.value) if self.value in tuple(SectionSize) else None

    @property
    def matrices(self) -> tuple[str, ...]:
        """Matrices of an element that move with it."""
        return _MATRICES_BY_PART.get(self, (self.value,))

    @property
    def nominal(self) -> float:
        """Coefficient that leaves the model as it is."""
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

    Properties may share a matrix: which of them is wrong, other matrices or nothing may tell.
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
