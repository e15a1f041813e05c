"""Bars and shells of a mesh in space."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.dof import DIRECTIONS, Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.damping import Damping
from modallab.fe.imported_elements import Element, Places, of_elements
from modallab.fe.settings import INPUT
from modallab.fe.spatial import (
    SpatialBars,
    SpatialPlates,
    bar_axes,
    bars_in_space,
    convex,
    plates_in_space,
    warp,
)
from modallab.fe.structure import Structure, Support
from modallab.interchange.mesh.described import BarMade, Made, PlateMade

Rim = tuple[int, ...]
Matrices = tuple[FloatArray, FloatArray, FloatArray]  # mass, axial or membrane, and bending stiffness
UPRIGHT, BESIDE = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)
STEEP = 1e-6  # of a bar's direction, by which it must stand off Z for Z to turn it


@dataclass(frozen=True, eq=False)
class SpaceCell:
    """A member of a mesh: its number, its group, what it is made of, its nodes."""

    number: int
    group: str
    made: Made
    rim: Rim


def in_space(
    cells: Sequence[SpaceCell],
    places: Places,
    *,
    supports: tuple[Support, ...],
    damping: Damping | None,
    name: str,
) -> Structure:
    """Return the structure of bars and shells, with six degrees of freedom a node.

    Raises
    ------
    InvalidInputError
        If a bar has no length or lies along the vector that turns it, or a shell is folded or warped.
    """
    dofs = [Dof(node, direction) for node in places for direction in DIRECTIONS]
    first = {node: 6 * i for i, node in enumerate(places)}
    elements: list[Element] = []
    for size in (2, 3, 4):
        alike = [cell for cell in cells if len(cell.rim) == size]
        if not alike:
            continue
        corners = np.array([[places[node] for node in cell.rim] for cell in alike])
        matrices = _bars(alike, corners) if size == 2 else _shells(alike, corners)
        for cell, mass, axial, bending in zip(alike, *matrices, strict=True):
            rows = [first[node] + i for node in cell.rim for i in range(6)]
            elements.append(Element(cell.number, cell.group, rows, mass, axial, bending))
    elements.sort(key=lambda element: element.number)
    return of_elements(elements, dofs, places, supports=supports, damping=damping, name=name)


def _bars(cells: Sequence[SpaceCell], ends: FloatArray) -> Matrices:
    made = [cell.made for cell in cells if isinstance(cell.made, BarMade)]
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    _refuse(cells, np.asarray(length > 0), "a bar without length", "two points apart")
    steep = np.abs(along[:, 2]) > (1 - STEEP) * length
    usual = np.where(steep[:, None], BESIDE, UPRIGHT)
    own = np.array([np.full(3, np.nan) if one.upright is None else one.upright for one in made], float)
    area = np.array([one.section.area for one in made])
    second = np.array([_second_moments(one) for one in made])
    density = np.array([one.material.density for one in made])
    bars = SpatialBars(
        along=along,
        upright=np.where(np.isnan(own), usual, own),
        modulus=np.array([one.material.modulus for one in made]),
        shear_modulus=np.array([one.material.shear_modulus for one in made]),
        area=area,
        second_moments=second,
        torsion=np.array([sum(_second_moments(one)) if one.torsion is None else one.torsion for one in made]),
        line_mass=density * area,
        polar_mass=density * second.sum(axis=1),
        shear_coefficients=np.zeros((len(made), 2)),
    )
    turned = np.asarray(np.isfinite(bar_axes(bars)).all(axis=(1, 2)))
    _refuse(cells, turned, "a bar along the vector that turns it", "an `upright` across the bar")
    return bars_in_space(bars)


def _second_moments(made: BarMade) -> tuple[float, float]:
    own = made.section.second_moment
    return own, own if made.second_moment_across is None else made.second_moment_across


def _shells(cells: Sequence[SpaceCell], corners: FloatArray) -> Matrices:
    made = [cell.made for cell in cells if isinstance(cell.made, PlateMade)]
    _refuse(cells, convex(corners), "a folded, hollow or flat cell", "corners round a convex shape")
    _refuse(
        cells,
        warp(corners) <= INPUT.max_warp,
        "a warped cell",
        f"corners in one plane, to {INPUT.max_warp:g} of its size",
    )
    plates = SpatialPlates(
        corners=corners,
        thickness=np.array([one.thickness for one in made]),
        modulus=np.array([one.material.modulus for one in made]),
        density=np.array([one.material.density for one in made]),
        poisson_ratio=np.array([one.material.poisson_ratio for one in made]),
    )
    return plates_in_space(plates)


def _refuse(cells: Sequence[SpaceCell], good: BoolArray, what: str, allowed: str) -> None:
    wrong = [cell for cell, fine in zip(cells, good, strict=True) if not fine]
    if wrong:
        raise InvalidInputError(
            f"{what}: member {wrong[0].number} of {len(wrong)} such, of group {wrong[0].group}",
            field="mesh",
            value=", ".join(map(str, wrong[0].rim)),
            allowed=allowed,
        )
