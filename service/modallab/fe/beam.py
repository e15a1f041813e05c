"""Straight beams in bending."""

from modallab.core.errors import StructureError, bounds
from modallab.fe.damping import Damping, StructuralDamping
from modallab.fe.structure import (
    GroundSpringElement,
    Material,
    Member,
    PointMass,
    Section,
    Structure,
    Support,
    positive,
)


def beam(
    *,
    length: float,
    n_elements: int,
    section: Section,
    material: Material,
    damping: Damping | None = None,
    supports: tuple[Support, ...] = (),
    masses: tuple[PointMass, ...] = (),
    springs: tuple[GroundSpringElement, ...] = (),
    element: str = "frame",
    name: str = "",
) -> Structure:
    """Return a beam along X with nodes 1 to n_elements + 1 and DoFs Y and RZ.

    Parameters
    ----------
    length
        m.

    Raises
    ------
    StructureError
        If the length is not positive or there is no element.
    """
    positive(length, "length")
    if n_elements < 1:
        raise StructureError(
            "a beam needs an element", field="n_elements", value=n_elements, allowed=bounds(1)
        )
    return Structure(
        nodes={i + 1: (length * i / n_elements, 0.0) for i in range(n_elements + 1)},
        members=tuple(Member(i, (i, i + 1), section, material, element) for i in range(1, n_elements + 1)),
        supports=supports,
        masses=masses,
        springs=springs,
        damping=damping or StructuralDamping(),
        directions=("Y", "RZ"),
        name=name,
    )
