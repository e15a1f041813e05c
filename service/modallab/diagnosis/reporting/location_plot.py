"""Drawings of the disagreement: map over response and frequency, and sketch of the structure."""

from collections.abc import Iterable, Sequence

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.place import Channels, Dofs, Members, Place
from modallab.diagnosis.reporting import svg
from modallab.diagnosis.reporting.figures import residual
from modallab.diagnosis.reporting.legend import keys
from modallab.diagnosis.reporting.settings import DRAWING
from modallab.diagnosis.result import Diagnosis
from modallab.diagnosis.result_curves import FrfCurves
from modallab.fe.members import AnyMember, sides
from modallab.fe.structure import Structure

LEVEL_NAMES = ("below 2", "2 to 5", "5 to 15", "15 to 50", "above 50 random errors")
# Cabinet projection onto the page: depth goes up to the right at half its length.
CABINET_PROJECTION = np.array([[1.0, 0.0], [0.35, 0.35], [0.0, 1.0]])
FORCE_DIRECTIONS = {
    "X": (-1.0, 0.0),
    "Y": (0.0, 1.0),
    "Z": (-0.7, 0.7),
}  # direction from which the force arrow points, on the page


def location_drawings(diagnosis: Diagnosis) -> str:
    """Return the maps of the residuals, initial and final, and the sketch of the structure."""
    curves = diagnosis.curves.by_frf
    maps = [_figure(_map(curves, curves.before, "initial prediction"), "Initial prediction.")]
    if diagnosis.steps:
        maps.append(_figure(_map(curves, curves.after, "with the added effects"), "With the added effects."))
    else:
        maps.append(_figure(*_sketch_and_words(diagnosis)))
    legend = keys([(f"l{i}", name) for i, name in enumerate(LEVEL_NAMES)])
    caption = "Difference of predicted and measured FRFs, by response and frequency."
    if any(curves.held_out):
        caption += " Responses marked * took no part in any fit."
    drawings = f'<div class="two">{"".join(maps)}</div>'
    if diagnosis.steps:
        drawings += _figure(*_sketch_and_words(diagnosis), style="middle")
    return f'<p class="soft">{caption}<br/>{legend}</p>{drawings}'


def _figure(drawing: str, words: str, style: str = "") -> str:
    mark = f' class="{style}"' if style else ""
    return f"<figure{mark}>{drawing}<figcaption>{words}</figcaption></figure>"


def _map(curves: FrfCurves, predicted: ComplexArray, stage: str) -> str:
    """Return a map: a row for each FRF, cells over frequency coloured by residual."""
    difference = residual(curves, predicted)
    edges = np.unique(
        np.linspace(0, len(curves.freq), min(DRAWING.map_columns, len(curves.freq)) + 1).astype(int)
    )
    sums = np.add.reduceat(difference**2, edges[:-1], axis=0)
    levels = np.digitize(np.sqrt(sums / np.diff(edges)[:, None]), DRAWING.level_limits)  # (n_columns, n_out)
    n = len(curves.outputs)
    row_height = min(DRAWING.row_height, DRAWING.map_height / n)
    frequency_axis = svg.frequencies(curves.freq)
    height = svg.MARGIN["top"] + n * row_height + svg.MARGIN["bottom"]
    frame = svg.Frame(frequency_axis, svg.Axis(0.0, 1.0, (), ""), height=height)
    label_step = int(
        np.ceil(DRAWING.label_height / row_height)
    )  # rows between labels, which must not overlap
    spacing = float(curves.freq[-1] - curves.freq[0]) / len(curves.freq)
    ends = frame.across(curves.freq[0] + edges * spacing)
    parts = []
    several = len(set(curves.inputs)) > 1
    for i, (dof, is_held_out) in enumerate(zip(curves.outputs, curves.held_out, strict=True)):
        top = svg.MARGIN["top"] + i * row_height
        parts += _row(levels[:, i], ends, top, row_height)
        if i % label_step == 0:
            name = curves.name(i) if several else str(dof)
            label = f"{name} *" if is_held_out else name
            parts.append(svg.text(svg.MARGIN["left"] - 6, top + row_height / 2 + 4, label, "side"))
    return svg.chart(frame, f"difference by response and frequency, {stage}", parts)


def _row(levels: IntArray, ends: FloatArray, top: float, height: float) -> list[str]:
    starts = np.flatnonzero(np.diff(levels, prepend=-1))
    stops = np.append(starts[1:], len(levels))
    return [
        svg.rectangle(ends[a], top, ends[b] - ends[a] + 0.3, height - 0.6, f"l{levels[a]}")
        for a, b in zip(starts, stops, strict=True)
    ]


def _sketch_and_words(diagnosis: Diagnosis) -> tuple[str, str]:
    words = (
        "Structure with responses (arrows) and struck points, coloured by the difference of the initial "
        "prediction"
        if diagnosis.setup.roving_hammer
        else f"Structure with {_drive_points(diagnosis)} and responses, coloured by the difference of the "
        "initial prediction"
    )
    places = [step.effect.at for step in diagnosis.steps if step.effect.at is not None]
    return _sketch(diagnosis), f"{words}; added effects are marked." if places else f"{words}."


def _drive_points(diagnosis: Diagnosis) -> str:
    return "drive point (arrow)" if len(diagnosis.curves.inputs) == 1 else "drive points (arrows)"


def _sketch(diagnosis: Diagnosis) -> str:
    """Return a sketch of members and measured nodes, with rings at the places of added effects."""
    structure, curves = diagnosis.structure, diagnosis.curves
    frfs, roving_hammer = curves.by_frf, diagnosis.setup.roving_hammer
    at, height = _places(structure)
    parts = [_line("rim", at[a], at[b]) for a, b in _edges(structure.non_bar_members)]
    parts += [_line("member", at[a], at[b]) for a, b in _edges(structure.members)]
    rings = [_ring(step.effect.at, structure, at) for step in diagnosis.steps]
    squares = (residual(frfs, frfs.before)[1:] ** 2).mean(axis=0)
    shown = _coloured_dofs(frfs, squares, roving_hammer=roving_hammer)
    for dof, level in zip(
        shown, np.digitize(np.sqrt(list(shown.values())), DRAWING.level_limits), strict=True
    ):
        x, y = at[dof.node]
        parts.append(f'<circle class="l{level} node" cx="{x:.1f}" cy="{y:.1f}" r="5"/>')
    parts += [ring for ring in rings if ring]
    upright = _beside_vertical_members(structure, at)
    # Arrows at all points that a hammer struck would hide the structure: at the references, then.
    parts += [_arrow(dof, at, upright) for dof in (curves.outputs if roving_hammer else curves.inputs)]
    parts += _numbers(at, [dof.node for dof in shown], upright)
    return svg.drawing(DRAWING.width, height, "structure with measured responses", parts)


def _coloured_dofs(frfs: FrfCurves, squares: FloatArray, *, roving_hammer: bool) -> dict[Dof, float]:
    """Return the mean square of each response's FRFs, or with a roving hammer of each struck point's.

    Parameters
    ----------
    squares
        (n_frf,) mean squared residual of each FRF.
    """
    by_dof: dict[Dof, list[float]] = {}
    for dof, square in zip(frfs.inputs if roving_hammer else frfs.outputs, squares, strict=True):
        by_dof.setdefault(dof, []).append(float(square))
    return {dof: float(np.mean(values)) for dof, values in by_dof.items()}


def _edges(members: Iterable[AnyMember]) -> list[tuple[int, int]]:
    """Return the pairs of nodes that draw members, each pair once."""
    return list(dict.fromkeys((min(ends), max(ends)) for member in members for ends in sides(member)))


def _places(structure: Structure) -> tuple[dict[int, tuple[float, float]], float]:
    """Return the position of each node in the drawing, and the height of the drawing."""
    nodes = np.array(list(structure.nodes.values()))
    if nodes.shape[1] == 3 and np.ptp(nodes[:, 2]) > 0:
        nodes = nodes @ CABINET_PROJECTION
    low, span = nodes.min(axis=0), np.maximum(np.ptp(nodes, axis=0), 1e-12)
    scale = min((DRAWING.width - 2 * DRAWING.sketch_margin) / span[0], DRAWING.sketch_height / span[1])
    height = (
        float(span[1] * scale + 2 * DRAWING.sketch_margin) if span[1] > 1e-9 else 2 * DRAWING.sketch_margin
    )
    margin = (DRAWING.width - span[0] * scale) / 2
    positions = [
        (margin + (x - low[0]) * scale, height - DRAWING.sketch_margin - (y - low[1]) * scale)
        for x, y in nodes[:, :2]
    ]
    return dict(zip(structure.nodes, [(float(x), float(y)) for x, y in positions], strict=True)), height


def _line(style: str, start: tuple[float, float], end: tuple[float, float]) -> str:
    return f'<path class="{style}" d="M{start[0]:.1f},{start[1]:.1f}L{end[0]:.1f},{end[1]:.1f}"/>'


def _ring(place: Place, structure: Structure, at: dict[int, tuple[float, float]]) -> str:
    if isinstance(place, Members):
        ends = _edges(structure.member(number) for number in place.numbers)
        return "".join(_line("marked", at[a], at[b]) for a, b in ends)
    dofs = place.dofs if isinstance(place, Channels | Dofs) else (place,) if isinstance(place, Dof) else ()
    return "".join(
        f'<circle class="ring" cx="{at[dof.node][0]:.1f}" cy="{at[dof.node][1]:.1f}" r="10"/>' for dof in dofs
    )


def _beside_vertical_members(structure: Structure, at: dict[int, tuple[float, float]]) -> set[int]:
    """Return the nodes of vertical members alone, which have room for a label beside them, not above."""
    ends = np.array(_edges(structure.all_members)).reshape(-1, 2)
    across, up = np.abs([np.subtract(at[a], at[b]) for a, b in ends.tolist()]).reshape(-1, 2).T
    return set(ends[across < up].ravel().tolist()) - set(ends[up < 1].ravel().tolist())


def _arrow(drive: Dof, at: dict[int, tuple[float, float]], upright: set[int]) -> str:
    """Return an arrow that points at the drive point in the direction of the force."""
    x, y = at[drive.node]
    dx, dy = FORCE_DIRECTIONS[drive.direction]
    if drive.direction == "Y" and drive.node in upright:  # beside its member, which would cover it
        x, y = x + (14.0 if x < DRAWING.width / 2 else -14.0), y - 9.0
    tip, tail = (x + 9 * dx, y + 9 * dy), (x + 30 * dx, y + 30 * dy)
    wings = [(tip[0] + 6 * dx + 4 * dy * s, tip[1] + 6 * dy - 4 * dx * s) for s in (-1, 1)]
    head = (
        f"M{wings[0][0]:.1f},{wings[0][1]:.1f}L{tip[0]:.1f},{tip[1]:.1f}L{wings[1][0]:.1f},{wings[1][1]:.1f}"
    )
    return _line("force", tail, tip) + f'<path class="force" d="{head}"/>'


def _numbers(at: dict[int, tuple[float, float]], nodes: Sequence[int], upright: set[int]) -> list[str]:
    """Return the numbers of nodes as labels, except those that would overlap another."""
    labels: list[tuple[float, float]] = []
    middle = sum(y for _, y in at.values()) / len(at)
    parts = []
    for node in sorted(set(nodes)):
        x, y = at[node]
        outward = -20.0 if x < DRAWING.width / 2 else 20.0
        outside = (x, y + 22) if y > middle + 1 else (x, y - 14)  # on the outer side of a frame
        position = (x + outward, y + 4) if node in upright else outside
        if any(
            abs(position[0] - a) < DRAWING.label_distance[0]
            and abs(position[1] - b) < DRAWING.label_distance[1]
            for a, b in labels
        ):
            continue
        labels.append(position)
        parts.append(svg.text(*position, str(node), "tick"))
    return parts
