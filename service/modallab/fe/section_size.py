"""Section sizes and thickness of members, and derivatives of their matrices."""

from collections.abc import Sequence
from dataclasses import replace
from enum import StrEnum
from typing import Any

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.core.numerics import COMPLEX_STEP
from modallab.fe.element import ELEMENTS
from modallab.fe.member_matrices import bar_of, member_matrices, rotated
from modallab.fe.members import AnyMember, MatrixElement, Member, Plate
from modallab.fe.structure import Structure


class SectionSize(StrEnum):
    """Area, second moment or thickness as a parameter of a member's matrices."""

    AREA = "area"  # of a bar, m^2
    SECOND_MOMENT = "second_moment"  # of a bar, m^4
    THICKNESS = "thickness"  # of a plate, m


def size(member: AnyMember, shape: SectionSize, *, field: str = "property") -> float:
    """Return area, m^2, or second moment, m^4, of a bar, or the thickness of a plate, m.

    Raises
    ------
    InvalidInputError
        If a member of this kind has none; `field` is the request field at fault.
    """
    if isinstance(member, Member) and shape is not SectionSize.THICKNESS:
        return float(getattr(member.section, shape.value))
    if isinstance(member, Plate) and shape is SectionSize.THICKNESS:
        return member.thickness
    kinds = {
        Member: ("a bar", [SectionSize.AREA, SectionSize.SECOND_MOMENT]),
        Plate: ("a plate", [SectionSize.THICKNESS]),
        MatrixElement: ("given by its matrices", "what multiplies these"),
    }
    kind, sizes = kinds[type(member)]
    raise InvalidInputError(
        f"member {member.number} is {kind}, which has no {shape.replace('_', ' ')}",
        field=field,
        value=shape.value,
        allowed=sizes,
    )


def resized(member: AnyMember, shape: SectionSize, to: float) -> AnyMember:
    """Return the member with another area, m^2, second moment, m^4, or thickness, m; its factors stay.

    Raises
    ------
    InvalidInputError
        If it has none.
    StructureError
        If no member is of that size.
    """
    size(member, shape)
    if isinstance(member, Plate):
        return replace(member, thickness=to)
    assert isinstance(member, Member)
    part: dict[str, Any] = {shape.value: to}
    return replace(member, section=replace(member.section, **part))


def size_derivatives(
    structure: Structure, members: Sequence[AnyMember], shape: SectionSize, width: int
) -> FloatArray:
    """Return derivatives of mass, axial and bending stiffness by the logarithm of a size.

    (3, n, width, width), factors left out, exact: of bars by the complex step, whatever law an element
    follows. A plate's mass and stiffness are made of t (translation, membrane, transverse shear) and t^3
    (turning normals, bending), and of these t dX/dt = (X(t) + X(2 t)) / 3.

    Parameters
    ----------
    members
        (n,) that have the size, at nodes of the structure.
    """
    if shape is SectionSize.THICKNESS:
        nominal = member_matrices(structure, members, width)
        doubled = member_matrices(
            structure, [resized(plate, shape, 2 * size(plate, shape)) for plate in members], width
        )
        pairs = (
            (nominal.mass, doubled.mass),
            (nominal.axial, doubled.axial),
            (nominal.bending, doubled.bending),
        )
        return np.array([(single + double) / 3 for single, double in pairs])
    bars = [member for member in members if isinstance(member, Member)]
    local = []
    for member in bars:
        bar = bar_of(structure, member)
        perturbed: dict[str, Any] = {shape.value: complex(1, COMPLEX_STEP) * size(member, shape)}
        local.append(ELEMENTS[member.element](replace(bar, **perturbed)))
    out = np.zeros((3, len(bars), width, width))
    out[:, :, :6, :6] = rotated(structure, bars, local).imag / COMPLEX_STEP
    return out
