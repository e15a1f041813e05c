"""Coefficients of properties in the unit of the property: what it was, and what it came to."""

from dataclasses import dataclass

from modallab.core.arrays import FloatArray
from modallab.fe.members import AnyMember, MatrixElement
from modallab.fe.section_size import size
from modallab.fe.structure import Structure
from modallab.updating.identifiability import Identifiability
from modallab.updating.nodal_elements import carried
from modallab.updating.parameterisation import Parameterisation, Part

UNITS = {
    Part.DENSITY: "kg/m^3",
    Part.MODULUS: "N/m^2",
    Part.AREA: "m^2",
    Part.SECOND_MOMENT: "m^4",
    Part.THICKNESS: "m",
    Part.POINT_MASS: "kg",
    Part.GROUND_SPRING_X: "N/m",
    Part.GROUND_SPRING_Y: "N/m",
    Part.GROUND_SPRING_Z: "N/m",
    Part.GROUND_SPRING_RX: "N m/rad",
    Part.GROUND_SPRING_RY: "N m/rad",
    Part.GROUND_SPRING_RZ: "N m/rad",
    Part.JOINT_STIFFNESS: "N m/rad",
}
ALIKE = 1e-9  # relative difference of members that share a value but for rounding


@dataclass(frozen=True)
class Quantity:
    """A property of some members, or what some nodes carry, before and after an update."""

    part: Part
    members: tuple[int, ...]
    unit: str
    before: float
    after: float
    interval: tuple[float, float] | None  # that holds it with 95 %, by the data alone


def quantities(
    structure: Structure,
    parameterisation: Parameterisation,
    values: FloatArray,
    told: Identifiability | None = None,
) -> tuple[Quantity, ...]:
    """Return what the coefficients of properties make of these; those that members do not share are left out.

    Parameters
    ----------
    structure
        The model before.
    values
        (n_params,) coefficients.
    told
        What the data say of them, if that is known.
    """
    found = []
    for i, macro in enumerate(parameterisation.macros):
        known = macro.part.physical or macro.part.at_node
        before = _shared(structure, macro.members, macro.part) if known else None
        if before is not None:
            interval = None
            if told is not None:
                low, high = before * told.intervals[i]
                interval = (float(low), float(high))
            after = before * float(values[i])
            found.append(Quantity(macro.part, macro.members, UNITS[macro.part], before, after, interval))
    return tuple(found)


def _shared(structure: Structure, members: tuple[int, ...], part: Part) -> float | None:
    """Return the value that all members have, None if there is none."""
    own: list[float | None]
    if part.at_node:
        at_nodes = carried(structure, part)
        own = [at_nodes[node] for node in members]
    else:
        own = [_value(structure.member(number), part) for number in members]
    known = [value for value in own if value is not None]
    if len(known) < len(own) or max(known) - min(known) > ALIKE * max(known):
        return None
    return known[0]


def _value(member: AnyMember, part: Part) -> float | None:
    """Return a member's property with the factors that it carries; None of one given by its matrices."""
    if part.shape is not None:
        return size(member, part.shape)
    if isinstance(member, MatrixElement):
        return None
    if part is Part.DENSITY:
        return member.mass_factor * member.material.density
    one, other = member.axial_factor, member.bending_factor
    return member.material.modulus * one if abs(one - other) <= ALIKE * one else None
