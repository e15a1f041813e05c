"""Corrected properties in their own units, before and after an update."""

import math
from dataclasses import dataclass, field

from modallab.core.arrays import FloatArray
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.core.reply import NanFloat
from modallab.fe.members import AnyMember, MatrixElement
from modallab.fe.section_size import size
from modallab.fe.structure import Structure
from modallab.updating.identifiability import Identifiability
from modallab.updating.nodal_elements import nodal_values
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


@dataclass(frozen=True)
class Quantity:
    """Property of members, or value of nodes, before and after an update."""

    part: Part
    """Corrected part."""
    members: tuple[int, ...]
    """Members, or nodes for parts of nodes."""
    unit: str
    """SI unit of the values."""
    before: float
    """Value of the model."""
    after: float
    """Updated value."""
    interval: tuple[float, float] | None
    """95 % confidence interval by the data alone; None without an error estimate."""
    change: NanFloat = field(init=False)
    """1, relative change: updated over original value, minus 1; None of a value that was 0."""

    def __post_init__(self) -> None:
        change = self.after / self.before - 1 if self.before else math.nan
        object.__setattr__(self, "change", change)


def quantities(
    structure: Structure,
    parameterisation: Parameterisation,
    values: FloatArray,
    identifiability: Identifiability | None = None,
) -> tuple[Quantity, ...]:
    """Return the corrected properties in their units, without those that members do not share.

    Parameters
    ----------
    structure
        Model before the update.
    values
        (n_params,) coefficients.
    identifiability
        Confidence intervals, None if unknown.
    """
    converted = []
    for i, macro in enumerate(parameterisation.macros):
        has_unit = macro.part.is_property or macro.part.is_nodal
        initial_value = _common_value(structure, macro.members, macro.part) if has_unit else None
        if initial_value is not None:
            interval = None
            if identifiability is not None:
                low, high = initial_value * identifiability.intervals[i]
                interval = (float(low), float(high))
            updated_value = initial_value * float(values[i])
            converted.append(
                Quantity(macro.part, macro.members, UNITS[macro.part], initial_value, updated_value, interval)
            )
    return tuple(converted)


def _common_value(structure: Structure, members: tuple[int, ...], part: Part) -> float | None:
    """Return the value that all members have, None if they differ."""
    values: list[float | None]
    if part.is_nodal:
        values_by_node = nodal_values(structure, part)
        values = [values_by_node[node] for node in members]
    else:
        values = [_property_value(structure.member(number), part) for number in members]
    finite_values = [value for value in values if value is not None]
    if len(finite_values) < len(values) or max(finite_values) - min(
        finite_values
    ) > COMPARISON_ROUNDING * max(finite_values):
        return None
    return finite_values[0]


def _property_value(member: AnyMember, part: Part) -> float | None:
    """Return a member's property with its factors, None for a member given by matrices."""
    if part.section_size is not None:
        return size(member, part.section_size)
    if isinstance(member, MatrixElement):
        return None
    if part is Part.DENSITY:
        return member.mass_factor * member.material.density
    axial_factor, bending_factor = member.axial_factor, member.bending_factor
    return (
        member.material.modulus * axial_factor
        if abs(axial_factor - bending_factor) <= COMPARISON_ROUNDING * axial_factor
        else None
    )
