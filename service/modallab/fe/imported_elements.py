"""Structures from imported matrices: by element, or by named groups."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count

import numpy as np
from scipy.sparse import csc_array

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.errors import StructureError, bounds
from modallab.fe.blocks import Blocks
from modallab.fe.damping import Damping, StructuralDamping
from modallab.fe.matrix_checks import check_mass, make_symmetric, slowest_motions
from modallab.fe.members import MatrixElement
from modallab.fe.structure import Structure, Support
from modallab.fe.structure_settings import INPUT


@dataclass(frozen=True, eq=False)
class Element:
    """Matrices of one element at its degrees of freedom, by their place in a table."""

    number: int
    group: str
    rows: Sequence[int]  # (k,)
    mass: FloatArray  # (k, k) kg, kg m, kg m^2
    axial: FloatArray  # (k, k) N/m, N, N m; undivided stiffness too
    bending: FloatArray | None = None
    loss_factor: float | None = None


@dataclass(frozen=True, eq=False)
class GroupMatrices:
    """Contribution of one named group to the matrices of a model."""

    name: str
    mass: csc_array  # (n, n) kg, kg m, kg m^2
    stiffness: csc_array  # (n, n) N/m, N, N m


Places = Mapping[int, tuple[float, float, float]]  # m, by node


def of_elements(
    elements: Sequence[Element],
    dofs: Sequence[Dof],
    places: Places | None = None,
    *,
    supports: tuple[Support, ...] = (),
    damping: Damping | None = None,
    motions: FloatArray | None = None,
    name: str = "",
) -> Structure:
    """Return the structure assembled from elements.

    Parameters
    ----------
    dofs
        (n,) all degrees of freedom.
    places
        Node coordinates, m; None where they are not known.
    motions
        (n, k) candidates for rigid-body motions; by default the slowest motions of the matrices.

    Raises
    ------
    StructureError
        If a matrix is not symmetric, the mass not positive or the stiffness negative, or the structure
        cannot be analysed.
    """
    _check_table(dofs)
    blocks = _blocks(elements, dofs, supports, motions)
    return Structure(
        nodes={node: (0.0, 0.0, 0.0) if places is None else places[node] for node in _nodes(dofs)},
        members=(),
        non_bar_members=tuple(
            MatrixElement(
                element.number,
                tuple(dict.fromkeys(dofs[row].node for row in element.rows)),
                i,
                loss_factor=element.loss_factor,
                group=element.group,
            )
            for i, element in enumerate(elements)
        ),
        supports=supports,
        damping=damping or StructuralDamping(),
        directions=tuple(dict.fromkeys(dof.direction for dof in dofs)),
        name=name,
        blocks=blocks,
    )


def _blocks(
    elements: Sequence[Element],
    dofs: Sequence[Dof],
    supports: tuple[Support, ...],
    motions: FloatArray | None,
) -> Blocks:
    rows, mass, axial, bending = _padded(elements)
    labels = [f"element {element.number}" for element in elements]
    for part, of in ((mass, "mass"), (axial, "stiffness"), (bending, "stiffness")):
        make_symmetric(part, labels, of)
    free = _free(dofs, supports)
    free_block = np.ix_(free, free)
    total_mass, total_stiffness = (
        csc_array(_total(part, rows, len(dofs))[free_block]) for part in (mass, axial + bending)
    )
    check_mass(total_mass, [dofs[i] for i in free])
    if motions is None:
        slow = slowest_motions(total_mass, total_stiffness)
        motions = np.zeros((len(dofs), slow.shape[1]))
        motions[free] = slow
    return Blocks(tuple(dofs), rows, mass, axial, bending if bending.any() else None, motions)


def _padded(elements: Sequence[Element]) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    """Return rows (n, w), mass, axial and bending stiffness (n, w, w) of elements of several sizes."""
    if not elements:
        raise StructureError("a model needs elements", field="elements", value=0, allowed=bounds(1))
    width = max(len(element.rows) for element in elements)
    if len(elements) * width**2 > INPUT.max_element_values:
        raise StructureError(
            "the element matrices hold too many numbers",
            field="elements",
            value=len(elements) * width**2,
            allowed=bounds(
                maximum=INPUT.max_element_values,
                unit="elements times the square of the largest's degrees of freedom",
            ),
        )
    rows = np.full((len(elements), width), -1)
    mass, axial, bending = np.zeros((3, len(elements), width, width))
    for i, element in enumerate(elements):
        k = len(element.rows)
        rows[i, :k] = element.rows
        mass[i, :k, :k] = element.mass
        axial[i, :k, :k] = element.axial
        if element.bending is not None:
            bending[i, :k, :k] = element.bending
    return rows, mass, axial, bending


def of_groups(
    groups: Sequence[GroupMatrices],
    dofs: Sequence[Dof],
    places: Places | None = None,
    *,
    damping: Damping | None = None,
    name: str = "",
) -> Structure:
    """Return the structure assembled from named groups.

    A small group is one member. Groups of a large model are divided into members of two nodes each, whose
    matrices have a meaning only in sum: they share the coefficients of the group.

    Raises
    ------
    StructureError
        As `of_elements`.
    """
    _check_table(dofs)
    return of_elements(elements_of_groups(groups, dofs), dofs, places, damping=damping, name=name)


def elements_of_groups(
    groups: Sequence[GroupMatrices], dofs: Sequence[Dof], *, first: int = 1
) -> list[Element]:
    """Return the elements of named groups, see `of_groups`, numbered from `first`."""
    group_rows = [_nonzero_rows(group) for group in groups]
    n_values = len(groups) * max((len(rows) for rows in group_rows), default=0) ** 2
    number = count(first)
    _, node, sizes = np.unique([dof.node for dof in dofs], return_inverse=True, return_counts=True)
    n_pairs = sum(_n_pairs(group, node) for group in groups) if n_values > INPUT.max_whole_group_values else 0
    if (
        n_values <= INPUT.max_whole_group_values
        or n_pairs > INPUT.max_pair_elements
        or n_pairs * (2 * sizes.max()) ** 2 > n_values
    ):
        return [
            Element(next(number), group.name, rows.tolist(), *_dense(group, rows))
            for group, rows in zip(groups, group_rows, strict=True)
            if len(rows)
        ]
    return [element for group in groups for element in _pairs(group, dofs, number)]


def _dense(group: GroupMatrices, rows: IntArray) -> tuple[FloatArray, FloatArray]:
    at = np.ix_(rows, rows)
    return group.mass[at].toarray(), group.stiffness[at].toarray()


def _nonzero_rows(group: GroupMatrices) -> IntArray:
    """Return the rows with an entry of a group."""
    return np.unique(np.concatenate(_entries(group)))


def _entries(group: GroupMatrices) -> tuple[IntArray, IntArray]:
    """Return rows and columns of the non-zero entries of a group's matrices."""
    matrices = [matrix.tocoo() for matrix in (group.mass, group.stiffness)]
    rows, columns = ([getattr(e, name)[e.data != 0] for e in matrices] for name in ("row", "col"))
    return np.concatenate(rows), np.concatenate(columns)


def _n_pairs(group: GroupMatrices, node: IntArray) -> int:
    """Return the number of node pairs that a group connects; `node` (n,) of each degree of freedom."""
    ends = np.sort([node[places] for places in _entries(group)], axis=0)
    return len(np.unique(ends, axis=1).T)


def _pairs(group: GroupMatrices, dofs: Sequence[Dof], number: Iterator[int]) -> Iterator[Element]:
    """Yield a group's matrices by pairs of nodes; entries at a single node are a pair with itself."""
    _, node = np.unique([dof.node for dof in dofs], return_inverse=True)
    at = [np.flatnonzero(node == i) for i in range(node.max() + 1)]
    parts: dict[tuple[int, int], list[tuple[int, int, int, float]]] = {}
    for kind, matrix in enumerate((group.mass, group.stiffness)):
        entries = matrix.tocoo()
        for row, column, value in zip(entries.row, entries.col, entries.data, strict=True):
            ends = sorted((int(node[row]), int(node[column])))
            parts.setdefault((ends[0], ends[1]), []).append((kind, int(row), int(column), float(value)))
    for (first_node, second_node), numbers in parts.items():
        rows = (
            at[first_node] if first_node == second_node else np.concatenate([at[first_node], at[second_node]])
        )
        place = {int(row): i for i, row in enumerate(rows)}
        matrices = np.zeros((2, len(rows), len(rows)))
        for kind, row, column, value in numbers:
            matrices[kind, place[row], place[column]] += value
        yield Element(next(number), group.name, rows.tolist(), *matrices)


def _total(parts: FloatArray, rows: IntArray, n: int) -> csc_array:
    r = np.broadcast_to(rows[:, :, None], parts.shape)
    c = np.broadcast_to(rows[:, None, :], parts.shape)
    valid = (r >= 0) & (c >= 0)
    return csc_array((parts[valid], (r[valid], c[valid])), shape=(n, n))


def _free(dofs: Sequence[Dof], supports: tuple[Support, ...]) -> IntArray:
    fixed = {(s.node, d) for s in supports for d in s.directions}
    free = [i for i, dof in enumerate(dofs) if (dof.node, dof.direction) not in fixed]
    if not free:
        raise StructureError("the supports hold every degree of freedom", field="supports")
    return np.array(free)


def _nodes(dofs: Sequence[Dof]) -> tuple[int, ...]:
    return tuple(dict.fromkeys(dof.node for dof in dofs))


def _check_table(dofs: Sequence[Dof]) -> None:
    if not dofs:
        raise StructureError("a model needs degrees of freedom", field="dofs", value=0, allowed=bounds(1))
    points: set[Dof] = set()
    for dof in dofs:
        if dof.sign < 0 or dof.point in points:
            raise StructureError(
                f"{dof} is there twice or in its negative sense",
                field="dofs",
                value=str(dof),
                allowed="each degree of freedom once, in its positive sense",
            )
        points.add(dof.point)
