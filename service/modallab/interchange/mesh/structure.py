"""Meshes as structures: in a plane, or in space."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import InvalidInputError
from modallab.fe.damping import Damping, StructuralDamping
from modallab.fe.members import Member, Plate
from modallab.fe.structure import ACROSS, PLANE, Structure, Support
from modallab.interchange.mesh.described import TAKES, BarMade, MeshDescription
from modallab.interchange.mesh.reading import Mesh
from modallab.interchange.mesh.space import SpaceCell, in_space

MOST = 40_000  # cells that become members
FLAT = 1e-9  # of its size, by which a mesh in X, Y may be off a plane
POINT = "vertex"  # a cell of one point: there is nothing of it to be made of


def structure_of_mesh(
    mesh: Mesh, described: MeshDescription | None, *, damping: Damping | None = None, name: str = ""
) -> Structure:
    """Return the structure that cells make: a frame in X, Y, a plate across it, or bars and shells in space.

    Nodes are numbered as the mesh's points, from 1, and members in the order of the cells that are described.

    Raises
    ------
    InvalidInputError
        If cells have no description or two, are of a type that is not read, or a group is unknown.
    """
    if described is None:
        raise InvalidInputError(
            "a mesh says nothing of sections and materials: describe its groups",
            field="mesh",
            value="none",
            allowed=_listed(mesh.groups),
        )
    owner = _owners(mesh, described)
    cells = np.flatnonzero(owner >= 0)
    if not 1 <= len(cells) <= MOST:
        raise InvalidInputError(
            "the mesh has no cell that is described, or too many",
            field="mesh",
            value=len(cells),
            allowed=f"1 to {MOST}",
        )
    names, corners = list(described.groups), mesh.corners
    groups = [names[owner[cell]] for cell in cells]
    rims = [tuple((corners[cell] + 1).tolist()) for cell in cells]
    used = sorted({node for rim in rims for node in rim})
    points = described.length_unit * mesh.points
    places = {
        node: (float(x), float(y), float(z))
        for node, (x, y, z) in zip(used, points[np.array(used) - 1], strict=True)
    }
    supports = _supports(mesh, described, used)
    members = [
        SpaceCell(number, group, described.groups[group], rim)
        for number, (group, rim) in enumerate(zip(groups, rims, strict=True), 1)
    ]
    if len({type(cell.made) for cell in members}) == 1 and _flat(np.array(list(places.values()))):
        return _plane(members, places, supports, damping=damping, name=name)
    return in_space(members, places, supports=supports, damping=damping, name=name)


def _flat(points: FloatArray) -> bool:
    return bool(np.ptp(points[:, 2]) <= FLAT * np.ptp(points, axis=0).max())


def _owners(mesh: Mesh, described: MeshDescription) -> IntArray:
    """Return which description each cell has, -1 of those that are left out."""
    types = np.array(mesh.types)
    owner = np.full(len(types), -1)
    out = (types == POINT) | np.isin(types, described.left_out)
    for group in (*described.left_out, *(held.group for held in described.supports)):
        out[mesh.groups.get(group, np.zeros(0, int))] = True
    for place, (group, made) in enumerate(described.groups.items()):
        cells = _cells(mesh, group)
        cells = cells[types[cells] != POINT]
        _refuse(mesh, cells[~np.isin(types[cells], TAKES[type(made)])], f"group {group}", TAKES[type(made)])
        _refuse(mesh, cells[owner[cells] >= 0], f"group {group} and another", ("each cell once",))
        owner[cells] = place
    _refuse(
        mesh, np.flatnonzero((owner < 0) & ~out), "no description", ("every cell described, or left out",)
    )
    return owner


def _cells(mesh: Mesh, group: str) -> IntArray:
    if group not in mesh.groups:
        raise _unknown(group, mesh.groups)
    return mesh.groups[group]


def _unknown(group: str, known: Mapping[str, IntArray]) -> InvalidInputError:
    return InvalidInputError(
        f"the mesh has no group {group!r}",
        field="mesh",
        value=group,
        allowed=_listed(known),
    )


def _listed(groups: Mapping[str, IntArray]) -> str:
    told = ", ".join(f"{name} ({len(of)})" for name, of in list(groups.items())[:50])
    return told or "none: the mesh has no groups"


def _refuse(mesh: Mesh, cells: IntArray, where: str, allowed: Sequence[str]) -> None:
    """Raise if there are such cells, with their types, how many there are, and the groups they are in."""
    if not len(cells):
        return
    types = mesh.types
    counted = Counter(types[cell] for cell in cells)
    inside = {name: len(np.intersect1d(of, cells)) for name, of in mesh.groups.items()}
    told = ", ".join(f"{name} ({n})" for name, n in inside.items() if n) or "no group"
    raise InvalidInputError(
        f"cells of {where}: {', '.join(f'{kind} ({n})' for kind, n in counted.items())}, in {told}",
        field="mesh",
        value=", ".join(counted),
        allowed=", ".join(allowed),
    )


def _supports(mesh: Mesh, described: MeshDescription, used: Sequence[int]) -> tuple[Support, ...]:
    """Return the supports of the nodes that there are, one for each."""
    there, corners = set(used), mesh.corners
    by_node: dict[int, dict[str, None]] = {}
    for held in described.supports:
        if held.group in mesh.point_groups:
            points = mesh.point_groups[held.group].tolist()
        elif held.group in mesh.groups:
            points = np.unique(np.concatenate([corners[cell] for cell in mesh.groups[held.group]])).tolist()
        else:
            raise _unknown(held.group, {**mesh.groups, **mesh.point_groups})
        for node in (point + 1 for point in points if point + 1 in there):
            by_node.setdefault(node, {}).update(dict.fromkeys(held.directions))
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
        made, rim = cell.made, cell.rim
        if isinstance(made, BarMade):
            bars.append(Member(cell.number, (rim[0], rim[1]), made.section, made.material, group=cell.group))
        else:
            plates.append(Plate(cell.number, rim, made.thickness, made.material, group=cell.group))
    return Structure(
        nodes={node: place[:2] for node, place in places.items()},
        members=tuple(bars),
        others=tuple(plates),
        supports=supports,
        damping=damping or StructuralDamping(),
        directions=ACROSS if plates else PLANE,
        name=name,
    )
