"""Matrices of every kind of member in the structure's axes."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.fe.element import ELEMENTS, Bar, ElementParts
from modallab.fe.facet import Facets, plate_matrices
from modallab.fe.members import AnyMember, Material, MatrixElement, Member, Plate, Section
from modallab.fe.settings import CACHE
from modallab.fe.structure import ACROSS, PLANE, Structure


@dataclass(frozen=True, eq=False)
class MemberMatrices:
    """Mass and stiffness of members, padded to the largest number of DoFs."""

    mass: FloatArray  # (n_members, w, w) kg, kg m, kg m^2
    axial: FloatArray  # (n_members, w, w) N/m, N, N m
    bending: FloatArray  # (n_members, w, w)
    rows: IntArray  # (n_members, w) rows of the system, -1 where a DoF is fixed or absent
    bars: BoolArray  # (n_members,) straight, with two ends


def bar_of(structure: Structure, member: Member) -> Bar:
    """Return a straight member in its own axes."""
    return _bar(structure.length(member), member.section, member.material)


def _bar(length: float, section: Section, material: Material) -> Bar:
    return Bar(
        length,
        section.area,
        section.second_moment,
        material.modulus,
        material.density,
        material.shear_modulus,
        section.shear_coefficient,
    )


@lru_cache(maxsize=CACHE.element_matrices)
def _parts(element: str, bar: Bar) -> ElementParts:
    return ELEMENTS[element](bar)


def member_matrices(
    structure: Structure, members: Sequence[AnyMember] | None = None, width: int = 0
) -> MemberMatrices:
    """Return the matrices of members, factors left out.

    Parameters
    ----------
    members
        Members of the structure or replacements of them; by default all of the structure.
    width
        Least width w of the matrices.
    """
    elements = structure.all_members if members is None else members
    bars, plates, blocks = (
        [(i, m) for i, m in enumerate(elements) if isinstance(m, kind)]
        for kind in (Member, Plate, MatrixElement)
    )
    widths = [6] if bars else []
    widths += [len(ACROSS) * len(plate.nodes) for _, plate in plates]
    widths += [structure.blocks.rows.shape[1]] if blocks and structure.blocks else []
    n, width = len(elements), max([width, *widths])
    mass, axial, bending = np.zeros((3, n, width, width))
    out = MemberMatrices(
        mass,
        axial,
        bending,
        rows=np.full((n, width), -1),
        bars=np.array([isinstance(member, Member) for member in elements]),
    )
    if bars:
        _fill_bars(out, structure, [i for i, _ in bars], [m for _, m in bars])  # type: ignore[misc]
    for corners in (3, 4):
        facets = [(i, m) for i, m in plates if len(m.nodes) == corners]
        if facets:
            _fill_plates(out, structure, [i for i, _ in facets], [m for _, m in facets])  # type: ignore[misc]
    if blocks:
        _fill_blocks(out, structure, [i for i, _ in blocks], [m for _, m in blocks])  # type: ignore[misc]
    return out


def _rows(structure: Structure, members: Sequence[Member | Plate], directions: Sequence[str]) -> IntArray:
    index = {(d.node, d.direction): i for i, d in enumerate(structure.dofs)}
    return np.array([[index.get((n, d), -1) for n in m.nodes for d in directions] for m in members])


def _fill_bars(out: MemberMatrices, structure: Structure, at: list[int], members: list[Member]) -> None:
    local = [_parts(member.element, bar_of(structure, member)) for member in members]
    out.mass[at, :6, :6], out.axial[at, :6, :6], out.bending[at, :6, :6] = rotated(structure, members, local)
    out.rows[at, :6] = _rows(structure, members, PLANE)


def rotated(structure: Structure, members: Sequence[Member], local: Sequence[ElementParts]) -> FloatArray:
    """Return mass, axial and bending stiffness of bars in the structure's axes, (3, n_bars, 6, 6)."""
    rotations = []
    for member in members:
        start, end = (np.array(structure.nodes[n]) for n in member.nodes)
        c, s = (end - start) / structure.length(member)
        rotation = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        rotations.append(np.kron(np.eye(2), rotation))
    transformation = np.array(rotations)
    parts = [[p.mass for p in local], [p.stiffness["axial"] for p in local]]
    return np.asarray(
        transformation.swapaxes(1, 2)
        @ np.array([*parts, [p.stiffness["bending"] for p in local]])
        @ transformation
    )


def _fill_plates(out: MemberMatrices, structure: Structure, at: list[int], plates: list[Plate]) -> None:
    facets = Facets(
        corners=np.array([[structure.nodes[n][:2] for n in plate.nodes] for plate in plates]),
        thickness=np.array([plate.thickness for plate in plates]),
        modulus=np.array([plate.material.modulus for plate in plates]),
        density=np.array([plate.material.density for plate in plates]),
        poisson_ratio=np.array([plate.material.poisson_ratio for plate in plates]),
    )
    mass, bending = plate_matrices(facets)
    width = mass.shape[1]
    out.mass[at, :width, :width] = mass
    out.bending[at, :width, :width] = bending
    out.rows[at, :width] = _rows(structure, plates, ACROSS)


def _fill_blocks(
    out: MemberMatrices, structure: Structure, at: list[int], members: list[MatrixElement]
) -> None:
    blocks = structure.blocks
    assert blocks is not None
    index = {dof: i for i, dof in enumerate(structure.dofs)}
    place = np.array([*(index.get(dof, -1) for dof in blocks.dofs), -1])  # the last one for padding
    block_indices = [member.index for member in members]
    width = blocks.rows.shape[1]
    out.mass[at, :width, :width] = blocks.mass[block_indices]
    out.axial[at, :width, :width] = blocks.axial[block_indices]
    if blocks.bending is not None:
        out.bending[at, :width, :width] = blocks.bending[block_indices]
    out.rows[at, :width] = place[blocks.rows[block_indices]]
