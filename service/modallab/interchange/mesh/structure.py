"""Meshes as structures: in a plane, or in space."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import InvalidInputError, bounds
from modallab.fe.damping import Damping, StructuralDamping
from modallab.fe.members import Member, Plate
from modallab.fe.structure import ACROSS, PLANE, Structure, Support
from modallab.interchange.mesh.description import CELL_TYPES, MeshBar, MeshDescription
from modallab.interchange.mesh.reading import Mesh
from modallab.interchange.mesh.space import SpaceCell, in_space
from modallab.interchange.settings import MODEL_FILE

POINT = "vertex"  # a cell of one point has no section


def structure_of_mesh(
    mesh: Mesh, description: MeshDescription | None, *, damping: Damping | None = None, name: str = ""
) -> Structure:
    """Return the structure that cells make: a frame in X, Y, a plate across it, or bars and shells in space.

    Nodes are numbered as the mesh's points, from 1, and members in the order of the cells that are described.

    Raises
    ------
    InvalidInputError
        If cells have no description or two, are of a type that is not read, or a group is unknown.
    """
    if description is None:
        raise InvalidInputError(
            "a mesh says nothing of sections and materials: describe its groups",
            field="mesh",
            value="none",
            allowed=_listed(mesh.groups),
        )
    owner = _owners(mesh, description)
    cells = np.flatnonzero(owner >= 0)
    if not 1 <= len(cells) <= MODEL_FILE.max_cells:
        raise InvalidInputError(
            "the mesh has no cell that is described, or too many",
            field="mesh",
            value=len(cells),
            allowed=bounds(1, MODEL_FILE.max_cells),
        )
    names, corners = list(description.groups), mesh.corners
    groups = [names[owner[cell]] for cell in cells]
    rims = [tuple((corners[cell] + 1).tolist()) for cell in cells]
    used = sorted({node for rim in rims for node in rim})
    points = description.length_unit * mesh.points
    places = {
        node: (float(x), float(y), float(z))
        for node, (x, y, z) in zip(used, points[np.array(used) - 1], strict=True)
    }
    supports = _supports(mesh, description, used)
    members = [
        SpaceCell(number, group, description.groups[group], rim)
        for number, (group, rim) in enumerate(zip(groups, rims, strict=True), 1)
    ]
    if len({type(cell.cell_property) for cell in members}) == 1 and _flat(np.array(list(places.values()))):
        return _plane(members, places, supports, damping=damping, name=name)
    return in_space(members, places, supports=supports, damping=damping, name=name)


def _flat(points: FloatArray) -> bool:
    return bool(np.ptp(points[:, 2]) <= MODEL_FILE.flatness * np.ptp(points, axis=0).max())


def _owners(mesh: Mesh, description: MeshDescription) -> IntArray:
    """Return the index of each cell's description, (n_cells,); -1 for ignored cells."""
    types = np.array(mesh.types)
    owner = np.full(len(types), -1)
    out = (types == POINT) | np.isin(types, description.left_out)
    for group in (*description.left_out, *(support.group for support in description.supports)):
        out[mesh.groups.get(group, np.zeros(0, int))] = True
    for position, (group, cell_property) in enumerate(description.groups.items()):
        cells = _cells(mesh, group)
        cells = cells[types[cells] != POINT]
        _refuse(
            mesh,
            cells[~np.isin(types[cells], CELL_TYPES[type(cell_property)])],
            f"group {group}",
            CELL_TYPES[type(cell_property)],
        )
        _refuse(mesh, cells[owner[cells] >= 0], f"group {group} and another", ("each cell once",))
        owner[cells] = position
    _refuse(
        mesh, np.flatnonzero((owner < 0) & ~out), "no description", ("every cell described, or left out",)
    )
    return owner


def _cells(mesh: Mesh, group: str) -> IntArray:
    if group not in mesh.groups:
        raise _unknown(group, mesh.groups)
    return mesh.groups[group]


def _unknown(group: str, groups: Mapping[str, IntArray]) -> InvalidInputError:
    return InvalidInputError(
        f"the mesh has no group {group!r}",
        field="mesh",
        value=group,
        allowed=_listed(groups),
    )


def _listed(groups: Mapping[str, IntArray]) -> list[str]:
    return [f"{name} ({len(of)})" for name, of in list(groups.items())[:50]]


def _refuse(mesh: Mesh, cells: IntArray, subject: str, requirement: Sequence[str]) -> None:
    """Raise if there are any refused cells, with their types, counts and groups."""
    if not len(cells):
        return
    types = mesh.types
    counts = Counter(types[cell] for cell in cells)
    inside = {name: len(np.intersect1d(of, cells)) for name, of in mesh.groups.items()}
    names = ", ".join(f"{name} ({n})" for name, n in inside.items() if n) or "no group"
    raise InvalidInputError(
        f"cells of {subject}: {', '.join(f'{kind} ({n})' for kind, n in counts.items())}, in {names}",
        field="mesh",
        value=list(counts),
        allowed=list(requirement),
    )


def _supports(mesh: Mesh, description: MeshDescription, used: Sequence[int]) -> tuple[Support, ...]:
    """Return the supports of the existing nodes, one for each node."""
    existing, corners = set(used), mesh.corners
    by_node: dict[int, dict[str, None]] = {}
    for support in description.supports:
        if support.group in mesh.point_groups:
            points = mesh.point_groups[support.group].tolist()
        elif support.group in mesh.groups:
            points = np.unique(
                np.concatenate([corners[cell] for cell in mesh.groups[support.group]])
            ).tolist()
        else:
            raise _unknown(support.group, {**mesh.groups, **mesh.point_groups})
        for node in (point + 1 for point in points if point + 1 in existing):
            by_node.setdefault(node, {}).update(dict.fromkeys(support.directions))
    return tuple(Support(node, tuple(directions)) for node, directions in by_node.items())


def _plane(
    cells: Sequence[SpaceCell],
    places: Mapping[int, tuple[float, float, float]],
    supports: tuple[Support, ...],
    *,
    damping: Damping | None,
    name: str,
) -> Structure:
    bars, plates = [], []
    for cell in cells:
        cell_property, rim = cell.cell_property, cell.rim
        if isinstance(cell_property, MeshBar):
            bars.append(
                Member(
                    cell.number,
                    (rim[0], rim[1]),
                    cell_property.section,
                    cell_property.material,
                    group=cell.group,
                )
            )
        else:
            plates.append(
                Plate(cell.number, rim, cell_property.thickness, cell_property.material, group=cell.group)
            )
    return Structure(
        nodes={node: place[:2] for node, place in places.items()},
        members=tuple(bars),
        non_bar_members=tuple(plates),
        supports=supports,
        damping=damping or StructuralDamping(),
        directions=ACROSS if plates else PLANE,
        name=name,
    )
