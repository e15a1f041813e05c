"""Flat rectangular plates in bending."""

from collections.abc import Iterator, Mapping
from enum import StrEnum

from modallab.core.errors import StructureError, bounds
from modallab.fe.damping import Damping, StructuralDamping
from modallab.fe.members import Material, Plate, positive
from modallab.fe.structure import ACROSS, GroundSpringElement, PointMass, Structure, Support


class Edge(StrEnum):
    """A side of a rectangle from 0, 0 to length, width."""

    LEFT = "left"  # X = 0
    RIGHT = "right"
    BOTTOM = "bottom"  # Y = 0
    TOP = "top"


class Holding(StrEnum):
    """Boundary condition of a side."""

    FREE = "free"
    SIMPLY_SUPPORTED = "simply_supported"  # no deflection, and so no slope along the side
    CLAMPED = "clamped"

    def directions(self, edge: Edge) -> tuple[str, ...]:
        """Return the fixed directions at the nodes of a side."""
        if self is Holding.SIMPLY_SUPPORTED:
            return ("Z", "RX" if edge in (Edge.LEFT, Edge.RIGHT) else "RY")
        return ACROSS if self is Holding.CLAMPED else ()


def plate(
    *,
    length: float,
    width: float,
    thickness: float,
    n_elements: tuple[int, int],
    material: Material,
    damping: Damping | None = None,
    edges: Mapping[Edge, Holding] | None = None,
    supports: tuple[Support, ...] = (),
    masses: tuple[PointMass, ...] = (),
    springs: tuple[GroundSpringElement, ...] = (),
    name: str = "",
) -> Structure:
    """Return a rectangular plate in X, Y with DoFs Z, RX and RY.

    Nodes are numbered row by row along X, beginning at the corner x = y = 0. Elements, each between four
    nodes, are numbered in the same way.

    Parameters
    ----------
    length, width, thickness
        m, along X, Y and Z.
    n_elements
        Along X and along Y.
    edges
        Boundary conditions of sides, by default free.

    Raises
    ------
    StructureError
        If a size is not positive or there is no element.
    """
    for size, name_of_size in ((length, "length"), (width, "width"), (thickness, "thickness")):
        positive(size, name_of_size)
    along, across = n_elements
    if along < 1 or across < 1:
        raise StructureError(
            "a plate needs an element each way",
            field="n_elements",
            value=[along, across],
            allowed=bounds(1),
        )
    return Structure(
        nodes=_grid(length, width, along, across),
        members=(),
        non_bar_members=tuple(
            Plate(number, nodes, thickness, material)
            for number, nodes in enumerate(_corners(along, across), 1)
        ),
        supports=(*supports, *_edge_supports(along, across, edges or {})),
        masses=masses,
        springs=springs,
        damping=damping or StructuralDamping(),
        directions=ACROSS,
        name=name,
    )


def _grid(length: float, width: float, along: int, across: int) -> dict[int, tuple[float, float]]:
    """Return X and Y, m, of the nodes by number, row by row."""
    row = along + 1
    return {
        row * j + i + 1: (length * i / along, width * j / across)
        for j in range(across + 1)
        for i in range(row)
    }


def _corners(along: int, across: int) -> Iterator[tuple[int, int, int, int]]:
    """Yield the four nodes of each element, row by row, counter-clockwise from the one nearest to 0, 0."""
    row = along + 1
    for j in range(across):
        for i in range(along):
            low, high = row * j + i + 1, row * (j + 1) + i + 1
            yield low, low + 1, high + 1, high


def _edge_supports(along: int, across: int, edges: Mapping[Edge, Holding]) -> tuple[Support, ...]:
    """Return the supports of the nodes of supported sides."""
    row = along + 1
    last = row * (across + 1)
    sides = {
        Edge.LEFT: range(1, last, row),
        Edge.RIGHT: range(row, last + 1, row),
        Edge.BOTTOM: range(1, row + 1),
        Edge.TOP: range(row * across + 1, last + 1),
    }
    return tuple(
        Support(node, directions)
        for edge, holding in edges.items()
        if (directions := holding.directions(edge))
        for node in sides[edge]
    )
