"""A structure's geometry as a universal file: nodes (dataset 15) and trace lines (82), out.

Not by pyuff 2.5: it keeps six digits of a place, and counts a trace line's nodes wrongly where one
follows itself.
"""

from collections.abc import Iterator, Sequence
from itertools import chain

from modallab.fe.members import sides
from modallab.fe.structure import Structure
from modallab.interchange.settings import UNIVERSAL
from modallab.interchange.uff_text import NOWHERE, Origin, dataset, front, label, rows

NODES, TRACE_LINE = 15, 82


def write(structure: Structure, origin: Origin = NOWHERE) -> bytes:
    """Return nodes, in m, and members as a universal file.

    Header (151) and SI units (164) come first. A trace line goes on from member to member as long
    as one begins where the one before ends.
    """
    name = label(structure.name) if structure.name.strip() else "members"
    lines = _trace_lines([side for member in structure.all_members for side in sides(member)])
    return b"".join(
        [
            front(origin),
            dataset(NODES, (_node(number, place) for number, place in structure.nodes.items())),
            *(dataset(TRACE_LINE, _trace(i, name, line)) for i, line in enumerate(lines, 1)),
        ]
    )


def _node(number: int, place: Sequence[float]) -> str:
    x, y, z = (*place, 0.0, 0.0)[:3]
    return f"{number:10d}{0:10d}{0:10d}{0:10d}{rows([x, y, z])[0]}"


def _trace(number: int, name: str, nodes: Sequence[int]) -> Iterator[str]:
    yield f"{number:10d}{len(nodes):10d}{0:10d}"
    yield name
    for at in range(0, len(nodes), UNIVERSAL.trace_nodes_per_row):
        yield "".join(f"{node:10d}" for node in nodes[at : at + UNIVERSAL.trace_nodes_per_row])


def _trace_lines(members: Sequence[tuple[int, int]]) -> Iterator[list[int]]:
    """Yield lists of nodes to draw through, lifts between."""
    strokes: list[list[int]] = []
    for first, second in members:
        last = strokes[-1] if strokes else []
        if last and last[-1] == first and len(last) < UNIVERSAL.max_trace_nodes:
            last.append(second)
        else:
            strokes.append([first, second])
    line: list[int] = []
    for stroke in strokes:
        if line and len(line) + 1 + len(stroke) > UNIVERSAL.max_trace_nodes:
            yield line
            line = []
        line = list(chain(line, [UNIVERSAL.pen_lift] if line else [], stroke))
    if line:
        yield line
