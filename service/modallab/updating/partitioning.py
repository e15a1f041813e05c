"""How members are divided into macro elements: by runs, by what they are made of, or by how they connect."""

from collections.abc import Iterable, Sequence

import numpy as np
from scipy.sparse import csr_array

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.fe.members import AnyMember, MatrixElement, Member
from modallab.fe.structure import Structure
from modallab.updating.graph_parts import graph_parts

Groups = tuple[tuple[int, ...], ...]

RUN_LENGTH = 4  # members in an automatic macro element of a small structure, at most
MOST_RUNS = 60  # runs beyond which parts of the structure take their place: more than modes can tell apart
UNLIKE = 0.1  # share of its weight that joins members of other section, thickness or material


def automatic_groups(structure: Structure) -> Groups:
    """Return macro elements for a structure that nobody has divided.

    Members that a model has under one name are one. Others that follow one another, bars in a straight
    line, of one section and material and with nothing else at the nodes between them, or plates side by
    side, are one run; a run is cut into the fewest pieces of at most four members, as equal as they can
    be. Seven make 4 + 3, as the thesis divides its bars. Where these would be more than 60, connected
    parts as of `partitioned` take their place.
    """
    named, unnamed = tuple(structure.groups.values()), _runs(structure)
    if len(unnamed) > MOST_RUNS:
        unnamed = _parts([m for m in structure.all_members if not m.group], MOST_RUNS)
    return (*named, *unnamed)


def property_groups(structure: Structure) -> Groups:
    """Return macro elements by what members are: one a name of a group, and of others one a section or
    thickness with its material."""
    found: dict[object, list[int]] = {}
    for member in structure.all_members:
        found.setdefault(member.group or _made_of(member), []).append(member.number)
    return tuple(tuple(numbers) for numbers in found.values())


def partitioned(structure: Structure, count: int | None = None) -> Groups:
    """Return macro elements that are connected parts of the structure, of about as many members each.

    They are cut where few members meet, and rather where section, thickness or material change.

    Parameters
    ----------
    count
        Macro elements; left out: a quarter of the members, 60 at most.

    Raises
    ------
    InvalidInputError
        If there are fewer members.
    """
    members = structure.all_members
    if count is None:
        count = min(-(-len(members) // RUN_LENGTH), MOST_RUNS)
    if not 1 <= count <= len(members):
        raise InvalidInputError(
            f"{len(members)} members make no {count} macro elements",
            field="macros",
            value=count,
            allowed=f"1 to {len(members)}",
        )
    return _parts(members, count)


def named_groups(structure: Structure, chosen: Iterable[str | Sequence[int]]) -> list[Sequence[int]]:
    """Return groups of members by number, some of which were chosen by their names in the structure.

    Raises
    ------
    InvalidInputError
        If the structure has no group of a name.
    """
    known = structure.groups
    for one in chosen:
        if isinstance(one, str) and one not in known:
            raise InvalidInputError(
                f"the structure has no group {one!r}",
                field="macros",
                value=one,
                allowed=", ".join(list(known)[:50]) or "members by number: this structure has no groups",
            )
    return [known[one] if isinstance(one, str) else one for one in chosen]


def _parts(members: Sequence[AnyMember], count: int) -> Groups:
    numbers = np.array([member.number for member in members])
    parts = graph_parts(_graph(members), count)
    return tuple(tuple(numbers[part].tolist()) for part in parts)


def _graph(members: Sequence[AnyMember]) -> csr_array:
    """Return the weights (n, n) that join members: the square of how many nodes they share.

    So plates along a side hold together more than those that meet at a corner.
    """
    ends = [(i, node) for i, member in enumerate(members) for node in member.nodes]
    row, node = np.array(ends).T
    _, column = np.unique(node, return_inverse=True)
    at_nodes = csr_array((np.ones(len(row)), (row, column)))
    shared = (at_nodes @ at_nodes.T).tocoo()
    kinds: dict[object, int] = {}
    kind = np.array([kinds.setdefault(member.group or _made_of(member), len(kinds)) for member in members])
    alike = np.where(kind[shared.row] == kind[shared.col], 1.0, UNLIKE)
    apart = shared.row != shared.col
    weights = (shared.data**2 * alike)[apart]
    return csr_array((weights, (shared.row[apart], shared.col[apart])), shape=shared.shape)


def _made_of(member: AnyMember) -> object:
    if isinstance(member, MatrixElement):
        return MatrixElement
    size = (member.section, member.element) if isinstance(member, Member) else member.thickness
    return type(member), size, member.material


def _runs(structure: Structure) -> Groups:
    """Return members without a name in runs of at most four."""
    at_node: dict[int, int] = {}
    for member in structure.all_members:
        for node in member.nodes:
            at_node[node] = at_node.get(node, 0) + 1

    def continues(one: AnyMember, other: AnyMember) -> bool:
        shared = set(one.nodes) & set(other.nodes)
        if not isinstance(one, Member) or not isinstance(other, Member):
            return type(one) is type(other) and len(shared) > 1
        alike = (one.section, one.material, one.element) == (other.section, other.material, other.element)
        return len(shared) == 1 and at_node[shared.pop()] == 2 and alike and _aligned(structure, one, other)

    runs: list[list[AnyMember]] = []
    last: AnyMember | None = None
    for member in structure.all_members:
        if member.group:
            last = None
            continue
        if last is not None and continues(last, member):
            runs[-1].append(member)
        else:
            runs.append([member])
        last = member
    pieces = (np.array_split([m.number for m in run], -(-len(run) // RUN_LENGTH)) for run in runs)
    return tuple(tuple(int(number) for number in piece) for run in pieces for piece in run)


def _aligned(structure: Structure, one: Member, other: Member) -> bool:
    def direction(member: Member) -> FloatArray:
        start, end = (np.array(structure.nodes[n]) for n in member.nodes)
        return np.asarray((end - start) / structure.length(member))

    return bool(abs(abs(direction(one) @ direction(other)) - 1.0) < 1e-9)
