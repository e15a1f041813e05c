"""Where model and measurement part, as pictures: on the structure, and over frequency and response."""

from collections.abc import Iterable, Sequence

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.place import Channels, Members, Place
from modallab.diagnosis.reporting import svg
from modallab.diagnosis.reporting.figures import residual
from modallab.diagnosis.reporting.legend import keys
from modallab.diagnosis.result import Diagnosis
from modallab.diagnosis.result_curves import Curves
from modallab.fe.members import AnyMember, sides
from modallab.fe.structure import Structure

LEVELS = (2.0, 5.0, 15.0, 50.0)  # random errors at which the colour changes
NAMES = ("below 2", "2 to 5", "5 to 15", "15 to 50", "above 50 random errors")
COLUMNS = 120
TALLEST, ROWS = 15.0, 300.0  # height of a row, and of all rows together
SIDE, ROOM = 40.0, 230.0  # margin of a structure's drawing, and its height at most
# Onto the paper: depth goes up to the right at half its length, as in a cabinet projection.
FROM_ASIDE = np.array([[1.0, 0.0], [0.35, 0.35], [0.0, 1.0]])
ARROWS = {"X": (-1.0, 0.0), "Y": (0.0, 1.0), "Z": (-0.7, 0.7)}  # where a force comes from, on the paper
APART = (22.0, 13.0)  # of two numbers in a drawing, at least, across or down


def where_drawn(diagnosis: Diagnosis) -> str:
    """Return the structure and the maps of what is left, before and after what was added."""
    curves = diagnosis.curves
    maps = [_figure(_map(curves, curves.before, "as given"), "The prediction as given.")]
    if diagnosis.steps:
        maps.append(_figure(_map(curves, curves.after, "with what was added"), "With what was added."))
    else:
        maps.append(_figure(*_sketch_and_words(diagnosis)))
    legend = keys([(f"l{i}", name) for i, name in enumerate(NAMES)])
    words = "How far predicted and measured FRFs are apart, by response and frequency."
    if any(curves.held_out):
        words += " Responses with a star took no part in any fit."
    drawn = f'<div class="two">{"".join(maps)}</div>'
    if diagnosis.steps:
        drawn += _figure(*_sketch_and_words(diagnosis), style="middle")
    return f'<p class="soft">{words}<br/>{legend}</p>{drawn}'


def _figure(picture: str, words: str, style: str = "") -> str:
    mark = f' class="{style}"' if style else ""
    return f"<figure{mark}>{picture}<figcaption>{words}</figcaption></figure>"


def _map(curves: Curves, predicted: ComplexArray, when: str) -> str:
    """Return a row for each response, a cell for each stretch of frequency, its colour the mean residual."""
    apart = residual(curves, predicted)[:, :, 0]
    edges = np.unique(np.linspace(0, len(curves.freq), min(COLUMNS, len(curves.freq)) + 1).astype(int))
    sums = np.add.reduceat(apart**2, edges[:-1], axis=0)
    levels = np.digitize(np.sqrt(sums / np.diff(edges)[:, None]), LEVELS)  # (n_columns, n_out)
    n = len(curves.outputs)
    tall = min(TALLEST, ROWS / n)
    across = svg.frequencies(curves.freq)
    height = svg.MARGIN["top"] + n * tall + svg.MARGIN["bottom"]
    frame = svg.Frame(across, svg.Axis(0.0, 1.0, (), ""), height=height)
    every = int(np.ceil(11.0 / tall))  # rows apart that names do not run into each other
    spacing = float(curves.freq[-1] - curves.freq[0]) / len(curves.freq)
    ends = frame.across(curves.freq[0] + edges * spacing)
    parts = []
    for i, (dof, held) in enumerate(zip(curves.outputs, curves.held_out, strict=True)):
        top = svg.MARGIN["top"] + i * tall
        parts += _row(levels[:, i], ends, top, tall)
        if i % every == 0:
            parts.append(svg.text(svg.MARGIN["left"] - 6, top + tall / 2 + 4, _starred(dof, held), "side"))
    return svg.chart(frame, f"difference by response and frequency, {when}", parts)


def _row(levels: IntArray, ends: FloatArray, top: float, tall: float) -> list[str]:
    starts = np.flatnonzero(np.diff(levels, prepend=-1))
    stops = np.append(starts[1:], len(levels))
    return [
        svg.rectangle(ends[a], top, ends[b] - ends[a] + 0.3, tall - 0.6, f"l{levels[a]}")
        for a, b in zip(starts, stops, strict=True)
    ]


def _starred(dof: Dof, held: bool) -> str:
    return f"{dof} *" if held else str(dof)


def _sketch_and_words(diagnosis: Diagnosis) -> tuple[str, str]:
    words = "The structure: drive point (arrow) and responses, each coloured by how far it is off as given"
    named = [step.effect.at for step in diagnosis.steps if step.effect.at is not None]
    return _sketch(diagnosis), f"{words}; what was added is marked." if named else f"{words}."


def _sketch(diagnosis: Diagnosis) -> str:
    """Return the members of the structure, its measured nodes, and rings where something was added."""
    structure, curves = diagnosis.structure, diagnosis.curves
    at, height = _places(structure)
    parts = [_line("rim", at[a], at[b]) for a, b in _drawn(structure.others)]
    parts += [_line("member", at[a], at[b]) for a, b in _drawn(structure.members)]
    rings = [_ring(step.effect.at, structure, at) for step in diagnosis.steps]
    off = np.sqrt((residual(curves, curves.before)[1:, :, 0] ** 2).mean(axis=0))
    for dof, level in zip(curves.outputs, np.digitize(off, LEVELS), strict=True):
        x, y = at[dof.node]
        parts.append(f'<circle class="l{level} node" cx="{x:.1f}" cy="{y:.1f}" r="5"/>')
    parts += [ring for ring in rings if ring]
    upright = _upright(structure, at)
    parts.append(_arrow(curves.inputs[0], at, upright))
    parts += _numbers(at, [dof.node for dof in curves.outputs], upright)
    return svg.drawing(svg.WIDTH, height, "the structure, and where it was measured", parts)


def _drawn(members: Iterable[AnyMember]) -> list[tuple[int, int]]:
    """Return the lines between nodes that draw members, a line between two of them once."""
    return list(dict.fromkeys((min(ends), max(ends)) for member in members for ends in sides(member)))


def _places(structure: Structure) -> tuple[dict[int, tuple[float, float]], float]:
    """Return where each node is in the drawing, and the drawing's height."""
    nodes = np.array(list(structure.nodes.values()))
    if nodes.shape[1] == 3 and np.ptp(nodes[:, 2]) > 0:
        nodes = nodes @ FROM_ASIDE
    low, span = nodes.min(axis=0), np.maximum(np.ptp(nodes, axis=0), 1e-12)
    scale = min((svg.WIDTH - 2 * SIDE) / span[0], ROOM / span[1])
    height = float(span[1] * scale + 2 * SIDE) if span[1] > 1e-9 else 2 * SIDE
    left = (svg.WIDTH - span[0] * scale) / 2
    drawn = [(left + (x - low[0]) * scale, height - SIDE - (y - low[1]) * scale) for x, y in nodes[:, :2]]
    return dict(zip(structure.nodes, [(float(x), float(y)) for x, y in drawn], strict=True)), height


def _line(style: str, start: tuple[float, float], end: tuple[float, float]) -> str:
    return f'<path class="{style}" d="M{start[0]:.1f},{start[1]:.1f}L{end[0]:.1f},{end[1]:.1f}"/>'


def _ring(place: Place, structure: Structure, at: dict[int, tuple[float, float]]) -> str:
    if isinstance(place, Members):
        ends = _drawn(structure.member(number) for number in place.numbers)
        return "".join(_line("marked", at[a], at[b]) for a, b in ends)
    dofs = place.dofs if isinstance(place, Channels) else (place,) if isinstance(place, Dof) else ()
    return "".join(
        f'<circle class="ring" cx="{at[dof.node][0]:.1f}" cy="{at[dof.node][1]:.1f}" r="10"/>' for dof in dofs
    )


def _upright(structure: Structure, at: dict[int, tuple[float, float]]) -> set[int]:
    """Return the nodes beside whose members there is room, and above whom there is none."""
    ends = np.array(_drawn(structure.all_members)).reshape(-1, 2)
    across, up = np.abs([np.subtract(at[a], at[b]) for a, b in ends.tolist()]).reshape(-1, 2).T
    return set(ends[across < up].ravel().tolist()) - set(ends[up < 1].ravel().tolist())


def _arrow(drive: Dof, at: dict[int, tuple[float, float]], upright: set[int]) -> str:
    """Return an arrow to the drive point, from the side that the force comes from."""
    x, y = at[drive.node]
    dx, dy = ARROWS[drive.direction]
    if drive.direction == "Y" and drive.node in upright:  # beside its member, which would hide it
        x, y = x + (14.0 if x < svg.WIDTH / 2 else -14.0), y - 9.0
    tip, tail = (x + 9 * dx, y + 9 * dy), (x + 30 * dx, y + 30 * dy)
    wings = [(tip[0] + 6 * dx + 4 * dy * s, tip[1] + 6 * dy - 4 * dx * s) for s in (-1, 1)]
    head = (
        f"M{wings[0][0]:.1f},{wings[0][1]:.1f}L{tip[0]:.1f},{tip[1]:.1f}L{wings[1][0]:.1f},{wings[1][1]:.1f}"
    )
    return _line("force", tail, tip) + f'<path class="force" d="{head}"/>'


def _numbers(at: dict[int, tuple[float, float]], nodes: Sequence[int], upright: set[int]) -> list[str]:
    """Return the numbers of nodes, those left out for which there is no room."""
    taken: list[tuple[float, float]] = []
    middle = sum(y for _, y in at.values()) / len(at)
    parts = []
    for node in sorted(set(nodes)):
        x, y = at[node]
        outward = -20.0 if x < svg.WIDTH / 2 else 20.0
        beyond = (x, y + 22) if y > middle + 1 else (x, y - 14)  # on the outer side of a frame
        place = (x + outward, y + 4) if node in upright else beyond
        if any(abs(place[0] - a) < APART[0] and abs(place[1] - b) < APART[1] for a, b in taken):
            continue
        taken.append(place)
        parts.append(svg.text(*place, str(node), "tick"))
    return parts
