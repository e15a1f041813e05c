"""Division of members into macro elements: by runs, by property, or by connectivity."""

from collections.abc import Iterable, Sequence

import numpy as np
from scipy.sparse import csr_array

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.fe.members import AnyMember, MatrixElement, Member
from modallab.fe.structure import Structure
from modallab.updating.graph_parts import graph_parts
from modallab.updating.partition_settings import PARTITION

Groups = tuple[tuple[int, ...], ...]


def automatic_groups(structure: Structure) -> Groups:
    """Return the default macro elements of a structure.

    Members of a named group are one macro element. Others that follow one another (bars in a straight line,
    of one section and material and with nothing else at the nodes between them, or plates side by side)
    form one run; a run is divided into the fewest pieces of at most four members, as equal as possible.
    Seven make 4 + 3, as the thesis divides its bars. Where these would be more than 60, connected parts as of
    `partitioned` take their place.
    """
    named_members, runs = tuple(structure.groups.values()), _runs(structure)
    if len(runs) > PARTITION.max_runs:
        runs = _connected_parts([m for m in structure.all_members if not m.group], PARTITION.max_runs)
    return (*named_members, *runs)


def property_groups(structure: Structure) -> Groups:
    """Return macro elements by property.

    One for each named group, and for other members one for each section or thickness with its material.
    """
    numbers_by_property: dict[object, list[int]] = {}
    for member in structure.all_members:
        numbers_by_property.setdefault(member.group or _property_key(member), []).append(member.number)
    return tuple(tuple(numbers) for numbers in numbers_by_property.values())


def partitioned(structure: Structure, count: int | None = None) -> Groups:
    """Return macro elements that are connected parts of the structure, of nearly equal numbers of members.

    They are cut where few members meet, preferably where section, thickness or material change.

    Parameters
    ----------
    count
        Macro elements; left out: a quarter of the members, 60 at most.

    Raises
    ------
    InvalidInputError
        If there are fewer members than macro elements.
    """
    members = structure.all_members
    if count is None:
        count = min(-(-len(members) // PARTITION.run_length), PARTITION.max_runs)
    if not 1 <= count <= len(members):
        raise InvalidInputError(
            f"{len(members)} members make no {count} macro elements",
            field="macros",
            value=count,
            allowed=bounds(1, len(members)),
        )
    return _connected_parts(members, count)


def named_groups(structure: Structure, groups: Iterable[str | Sequence[int]]) -> list[Sequence[int]]:
    """Return groups as member numbers; a group may be given by its name in the structure.

    Raises
    ------
    InvalidInputError
        If the structure has no group of a name.
    """
    groups_by_name = structure.groups
    for group in groups:
        if isinstance(group, str) and group not in groups_by_name:
            raise InvalidInputError(
                f"the structure has no group {group!r}",
                field="macros",
                value=group,
                allowed=list(groups_by_name)[:50] or "members by number: this structure has no groups",
            )
    return [groups_by_name[group] if isinstance(group, str) else group for group in groups]


def _connected_parts(members: Sequence[AnyMember], count: int) -> Groups:
    numbers = np.array([member.number for member in members])
    parts = graph_parts(_member_graph(members), count)
    return tuple(tuple(numbers[part].tolist()) for part in parts)


def _member_graph(members: Sequence[AnyMember]) -> csr_array:
    """Return the weights (n, n) of the graph of members: squared number of common nodes.

    Plates along a side are joined more strongly than those that meet at a corner.
    """
    ends = [(i, node) for i, member in enumerate(members) for node in member.nodes]
    row, node = np.array(ends).T
    _, column = np.unique(node, return_inverse=True)
    at_nodes = csr_array((np.ones(len(row)), (row, column)))
    common_nodes = (at_nodes @ at_nodes.T).tocoo()
    kinds: dict[object, int] = {}
    kind = np.array(
        [kinds.setdefault(member.group or _property_key(member), len(kinds)) for member in members]
    )
    similarity = np.where(
        kind[common_nodes.row] == kind[common_nodes.col], 1.0, PARTITION.dissimilarity_weight
    )
    off_diagonal = common_nodes.row != common_nodes.col
    weights = (common_nodes.data**2 * similarity)[off_diagonal]
    return csr_array(
        (weights, (common_nodes.row[off_diagonal], common_nodes.col[off_diagonal])), shape=common_nodes.shape
    )


def _property_key(member: AnyMember) -> object:
    if isinstance(member, MatrixElement):
        return MatrixElement
    size = (member.section, member.element) if isinstance(member, Member) else member.thickness
    return type(member), size, member.material


def _runs(structure: Structure) -> Groups:
    """Return unnamed members in runs of at most four."""
    at_node: dict[int, int] = {}
    for member in structure.all_members:
        for node in member.nodes:
            at_node[node] = at_node.get(node, 0) + 1

    def continues(previous: AnyMember, member: AnyMember) -> bool:
        common_nodes = set(previous.nodes) & set(member.nodes)
        if not isinstance(previous, Member) or not isinstance(member, Member):
            return type(previous) is type(member) and len(common_nodes) > 1
        same_property = (previous.section, previous.material, previous.element) == (
            member.section,
            member.material,
            member.element,
        )
        return (
            len(common_nodes) == 1
            and at_node[common_nodes.pop()] == 2
            and same_property
            and _aligned(structure, previous, member)
        )

    runs: list[list[AnyMember]] = []
    previous_member: AnyMember | None = None
    for member in structure.all_members:
        if member.group:
            previous_member = None
            continue
        if previous_member is not None and continues(previous_member, member):
            runs[-1].append(member)
        else:
            runs.append([member])
        previous_member = member
    pieces = (np.array_split([m.number for m in run], -(-len(run) // PARTITION.run_length)) for run in runs)
    return tuple(tuple(int(number) for number in piece) for run in pieces for piece in run)


def _aligned(structure: Structure, first: Member, second: Member) -> bool:
    def direction(member: Member) -> FloatArray:
        start, end = (np.array(structure.nodes[n]) for n in member.nodes)
        return np.asarray((end - start) / structure.length(member))

    return bool(abs(abs(direction(first) @ direction(second)) - 1.0) < COMPARISON_ROUNDING)
