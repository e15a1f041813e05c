"""Bars and shells of a mesh in space."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.dof import DIRECTIONS, Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.damping import Damping
from modallab.fe.imported_elements import Element, Places, of_elements
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
from modallab.fe.structure_settings import INPUT
from modallab.interchange.mesh.description import CellProperty, MeshBar, MeshPlate
from modallab.interchange.settings import MODEL_FILE

Rim = tuple[int, ...]
Matrices = tuple[FloatArray, FloatArray, FloatArray]  # mass, axial or membrane, and bending stiffness
Z_AXIS, Y_AXIS = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)


@dataclass(frozen=True, eq=False)
class SpaceCell:
    """Cell of a mesh that becomes a member: number, group, properties, nodes."""

    number: int
    group: str
    cell_property: CellProperty
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
        same_type = [cell for cell in cells if len(cell.rim) == size]
        if not same_type:
            continue
        corners = np.array([[places[node] for node in cell.rim] for cell in same_type])
        matrices = _bars(same_type, corners) if size == 2 else _shells(same_type, corners)
        for cell, mass, axial, bending in zip(same_type, *matrices, strict=True):
            rows = [first[node] + i for node in cell.rim for i in range(6)]
            elements.append(Element(cell.number, cell.group, rows, mass, axial, bending))
    elements.sort(key=lambda element: element.number)
    return of_elements(elements, dofs, places, supports=supports, damping=damping, name=name)


def _bars(cells: Sequence[SpaceCell], ends: FloatArray) -> Matrices:
    bar_properties = [cell.cell_property for cell in cells if isinstance(cell.cell_property, MeshBar)]
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    _refuse(cells, np.asarray(length > 0), "a bar without length", "two points apart")
    steep = np.abs(along[:, 2]) > (1 - MODEL_FILE.steepness) * length
    usual = np.where(steep[:, None], Y_AXIS, Z_AXIS)
    stated = np.array(
        [np.full(3, np.nan) if bar.upright is None else bar.upright for bar in bar_properties], float
    )
    area = np.array([bar.section.area for bar in bar_properties])
    second = np.array([_second_moments(bar) for bar in bar_properties])
    density = np.array([bar.material.density for bar in bar_properties])
    bars = SpatialBars(
        along=along,
        upright=np.where(np.isnan(stated), usual, stated),
        modulus=np.array([bar.material.modulus for bar in bar_properties]),
        shear_modulus=np.array([bar.material.shear_modulus for bar in bar_properties]),
        area=area,
        second_moments=second,
        torsion=np.array(
            [sum(_second_moments(bar)) if bar.torsion is None else bar.torsion for bar in bar_properties]
        ),
        line_mass=density * area,
        polar_mass=density * second.sum(axis=1),
        shear_coefficients=np.zeros((len(bar_properties), 2)),
    )
    turned = np.asarray(np.isfinite(bar_axes(bars)).all(axis=(1, 2)))
    _refuse(cells, turned, "a bar along the vector that turns it", "an `upright` across the bar")
    return bars_in_space(bars)


def _second_moments(bar: MeshBar) -> tuple[float, float]:
    in_plane = bar.section.second_moment
    return in_plane, in_plane if bar.second_moment_across is None else bar.second_moment_across


def _shells(cells: Sequence[SpaceCell], corners: FloatArray) -> Matrices:
    plate_properties = [cell.cell_property for cell in cells if isinstance(cell.cell_property, MeshPlate)]
    _refuse(cells, convex(corners), "a folded, hollow or flat cell", "corners round a convex shape")
    _refuse(
        cells,
        warp(corners) <= INPUT.max_warp,
        "a warped cell",
        f"corners in one plane, to {INPUT.max_warp:g} of its size",
    )
    plates = SpatialPlates(
        corners=corners,
        thickness=np.array([plate.thickness for plate in plate_properties]),
        modulus=np.array([plate.material.modulus for plate in plate_properties]),
        density=np.array([plate.material.density for plate in plate_properties]),
        poisson_ratio=np.array([plate.material.poisson_ratio for plate in plate_properties]),
    )
    return plates_in_space(plates)


def _refuse(cells: Sequence[SpaceCell], accepted: BoolArray, problem: str, requirement: str) -> None:
    wrong = [cell for cell, fine in zip(cells, accepted, strict=True) if not fine]
    if wrong:
        raise InvalidInputError(
            f"{problem}: member {wrong[0].number} of {len(wrong)} such, of group {wrong[0].group}",
            field="mesh",
            value=list(map(str, wrong[0].rim)),
            allowed=requirement,
        )
