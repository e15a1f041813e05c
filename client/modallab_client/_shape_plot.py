"""Pictures of structures and mode shapes, still and moving."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from modallab_client import _plots
from modallab_client.models import ComplexArray, FloatArray
from modallab_client.settings import SHAPE_PLOT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client.results import StructureGeometry

AXES = ("X", "Y", "Z")


@dataclass(frozen=True)
class Moved:
    """Nodes of a structure and their motion in one shape."""

    points: FloatArray  # (n_nodes, 3) m
    motion: ComplexArray  # (n_nodes, 3), the largest of the size that a plot shows
    lines: tuple[tuple[int, ...], ...]  # of each member, rows of `points`
    measured: tuple[int, ...]  # rows of `points` whose motion is known

    @property
    def is_plane(self) -> bool:
        """Whether nothing lies or moves along Z."""
        return not self.points[:, 2].any() and not self.motion[:, 2].any()


def moved(layout: "StructureGeometry", shape: Sequence[complex] | ComplexArray, dofs: Sequence[str]) -> Moved:
    """Return the motion of all nodes from that at some degrees of freedom; rotations are left out.

    Nodes without one lie on straight lines between those that have: each moves as the mean of its
    neighbours, weighted by the reciprocal of the distance.
    """
    numbers = list(layout.nodes)
    row = {number: i for i, number in enumerate(numbers)}
    points = np.zeros((len(numbers), 3))
    for number, place in layout.nodes.items():
        points[row[number], : len(place)] = place
    known: dict[int, ComplexArray] = {}
    for dof, value in zip(dofs, shape, strict=True):
        node, direction = dof.split(":")
        if direction[1:] in AXES and int(node) in row:
            sign = -1 if direction[0] == "-" else 1
            known.setdefault(row[int(node)], np.zeros(3, complex))[AXES.index(direction[1:])] += sign * value
    lines = tuple(tuple(row[node] for node in member.nodes) for member in layout.members)
    motion = _filled(points, lines, known)
    extent = np.linalg.norm(np.ptp(points, axis=0))
    largest = np.abs(motion).max(initial=0.0)
    scale = SHAPE_PLOT.size * extent / largest if largest > 0 else 0.0
    return Moved(points, scale * motion, lines, tuple(sorted(known)))


def _filled(
    points: FloatArray, lines: Sequence[Sequence[int]], known: Mapping[int, ComplexArray]
) -> ComplexArray:
    """Return the motion (n_nodes, 3) of all nodes."""
    n = len(points)
    motion = np.zeros((n, 3), complex)
    if not known:
        return motion
    stiffness = SHAPE_PLOT.hold * np.eye(n)  # what nothing known is connected to stays at rest
    for line in lines:
        ends = zip(line, (*line[1:], line[0]), strict=True) if len(line) > 2 else [tuple(line)]
        for i, j in ends:
            pull = 1 / max(float(np.linalg.norm(points[i] - points[j])), SHAPE_PLOT.hold)
            stiffness[[i, j], [i, j]] += pull
            stiffness[[i, j], [j, i]] -= pull
    fixed = sorted(known)
    free = [i for i in range(n) if i not in known]
    motion[fixed] = [known[i] for i in fixed]
    if free:
        motion[free] = np.linalg.solve(
            stiffness[np.ix_(free, free)], -stiffness[np.ix_(free, fixed)] @ motion[fixed]
        )
    return motion


def _axes(moving: Moved) -> Any:
    pyplot = _plots.pyplot()
    if moving.is_plane:
        _, axes = pyplot.subplots(figsize=(8, 3), layout="constrained")
        axes.set_ylabel("Y, m")
    else:
        axes = pyplot.figure(figsize=(7, 5)).add_subplot(projection="3d")
        axes.set(ylabel="Y, m", zlabel="Z, m")
    axes.set_xlabel("X, m")
    least = 0.5 * SHAPE_PLOT.size * float(np.linalg.norm(np.ptp(moving.points, axis=0)))
    limits = [(place.min(), place.max()) for place in _farthest(moving)]
    for name, (low, high) in zip("xyz", limits[: 2 if moving.is_plane else 3], strict=False):
        room = max(SHAPE_PLOT.margin * (high - low), least)
        getattr(axes, f"set_{name}lim")(low - room, high + room)
    axes.set_aspect("equal")
    return axes


def _farthest(moving: Moved) -> Any:
    size = np.abs(moving.motion)
    return np.concatenate([moving.points - size, moving.points + size]).T


def _draw(axes: Any, moving: Moved, points: FloatArray, style: str, **more: Any) -> list[Any]:
    """Draw the members with their nodes at some points; return the lines."""
    drawn = []
    for line in moving.lines:
        corners = [*line, line[0]] if len(line) > 2 else list(line)
        drawn += axes.plot(*_coordinates(moving, points[corners]), style, **more)
    return drawn


def _coordinates(moving: Moved, points: FloatArray) -> FloatArray:
    return np.asarray(points.T[: 2 if moving.is_plane else 3])


def _real(motion: ComplexArray) -> FloatArray:
    """Return a shape turned so that its largest part is real."""
    square = (motion**2).sum()
    return np.asarray((motion * np.exp(-0.5j * np.angle(square))).real)


def structure(layout: "StructureGeometry") -> "Axes":
    """Draw nodes and members with the numbers of the nodes; return the axes."""
    resting = moved(layout, (), ())
    axes = _axes(resting)
    _draw(axes, resting, resting.points, "C0-", linewidth=1.2)
    axes.plot(*_coordinates(resting, resting.points), "k.", markersize=4)
    step = max(1, round(len(layout.nodes) / SHAPE_PLOT.numbered_nodes))
    for number, place in list(zip(layout.nodes, resting.points, strict=True))[::step]:
        at = _coordinates(resting, place[None])[:, 0]
        axes.text(*at, f" {number}", fontsize="x-small", verticalalignment="bottom")
    axes.set_title(f"{layout.name}: {len(layout.nodes)} nodes, {len(layout.members)} members".lstrip(": "))
    return axes  # type: ignore[no-any-return]


def shape(moving: Moved, title: str) -> "Axes":
    """Draw a shape over the structure at rest; return the axes."""
    axes = _axes(moving)
    _draw(axes, moving, moving.points, "-", color="0.75", linewidth=0.8)
    there = moving.points + _real(moving.motion)
    _draw(axes, moving, there, "C0-", linewidth=1.4)
    axes.plot(*_coordinates(moving, there[list(moving.measured)]), "ko", markersize=3)
    axes.set_title(title)
    return axes  # type: ignore[no-any-return]


class MovingShape:
    """A mode shape that moves: shown by a notebook, or saved as a GIF or a web page."""

    def __init__(self, moving: Moved, title: str) -> None:
        self._moving, self._title = moving, title

    def save(self, path: str | Path) -> Path:
        """Write the animation and return its path.

        Parameters
        ----------
        path
            Ends with `.gif` or `.html`.

        Raises
        ------
        ValueError
            If it ends otherwise.
        """
        target = Path(path)
        if target.suffix == ".html":
            target.write_text(self._repr_html_(), encoding="utf-8")
        elif target.suffix == ".gif":
            self._animated(lambda animation: animation.save(target, writer="pillow", fps=SHAPE_PLOT.rate))
        else:
            raise ValueError(f"an animation is a .gif or a .html file, not {target.name}")
        return target

    def _repr_html_(self) -> str:
        text: str = self._animated(lambda animation: animation.to_jshtml(fps=SHAPE_PLOT.rate))
        return text

    def _animated(self, use: Any) -> Any:
        """Return what is made of the animation, whose figure is closed after it."""
        pyplot = _plots.pyplot()
        from matplotlib.animation import FuncAnimation

        moving = self._moving
        axes = shape(moving, self._title)
        n = len(moving.lines)
        lines = axes.lines[n : 2 * n]
        dots = axes.lines[2 * n]
        turned = moving.motion * np.exp(-0.5j * np.angle((moving.motion**2).sum()))

        def step(frame: int) -> list[Any]:
            phase = np.exp(2j * np.pi * frame / SHAPE_PLOT.frames)
            there = moving.points + (turned * phase).real
            for drawn, line in zip(lines, moving.lines, strict=True):
                corners = [*line, line[0]] if len(line) > 2 else list(line)
                _set(drawn, _coordinates(moving, there[corners]))
            _set(dots, _coordinates(moving, there[list(moving.measured)]))
            return [*lines, dots]

        animation = FuncAnimation(axes.figure, step, frames=SHAPE_PLOT.frames)  # type: ignore[arg-type]
        try:
            return use(animation)
        finally:
            pyplot.close(axes.figure)


def _set(line: Any, coordinates: FloatArray) -> None:
    if len(coordinates) == 2:
        line.set_data(*coordinates)
    else:
        line.set_data_3d(*coordinates)
