"""Charts as SVG (scalable vector graphics); the style sheet of the page sets their colours."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.reporting.settings import DRAWING

MARGIN = {"left": 58.0, "right": 20.0, "top": 8.0, "bottom": 40.0}


@dataclass(frozen=True)
class Axis:
    """Axis of a chart: limits, ticks with labels, name."""

    lower: float
    upper: float
    ticks: tuple[tuple[float, str], ...]
    label: str

    def at(self, values: FloatArray) -> FloatArray:
        """Return the positions of values along the axis, 0 to 1; values outside the limits lie at an end."""
        share = (values - self.lower) / (self.upper - self.lower)
        return np.asarray(np.clip(share, 0.0, 1.0))


@dataclass(frozen=True)
class Frame:
    """Area of a chart with two axes; without a horizontal label it shares the axis of the chart below."""

    x: Axis
    y: Axis
    width: float = DRAWING.width
    height: float = 220.0

    @property
    def bottom(self) -> float:
        """Vertical position of the lower edge of the plotted area."""
        return self.height - (MARGIN["bottom"] if self.x.label else DRAWING.bare_margin)

    def across(self, x: FloatArray) -> FloatArray:
        """Return horizontal positions in the drawing."""
        room = self.width - MARGIN["left"] - MARGIN["right"]
        return np.asarray(MARGIN["left"] + room * self.x.at(x))

    def down(self, y: FloatArray) -> FloatArray:
        """Return vertical positions in the drawing."""
        room = self.bottom - MARGIN["top"]
        return np.asarray(MARGIN["top"] + room * (1.0 - self.y.at(y)))


def linear(lower: float, upper: float, label: str, *, n_ticks: int = 6) -> Axis:
    """Return a linear axis with round tick values between the limits."""
    span = max(upper - lower, 1e-12)
    power = 10.0 ** np.floor(np.log10(span / n_ticks))
    step = next(s * power for s in DRAWING.tick_steps if s * power * n_ticks >= span)
    first = np.ceil(lower / step - 1e-9) * step
    values = np.arange(first, upper + 1e-9 * span, step)
    return Axis(lower, lower + span, tuple((float(v), f"{v + 0.0:.10g}") for v in values.round(12)), label)


def frequencies(freq: FloatArray) -> Axis:
    """Return the frequency axis, Hz."""
    return linear(float(freq[0]), float(freq[-1]), "frequency, Hz", n_ticks=6)


def decades(lower: float, upper: float, label: str) -> Axis:
    """Return an axis of common logarithms, with limits rounded outward to decades."""
    first, last = int(np.floor(lower)), int(np.ceil(upper))
    last = max(last, first + 1)
    skip = 1 + (last - first) // 8
    names = [(float(p), _power(p)) for p in range(first, last + 1, skip)]
    return Axis(first, last, tuple(names), label)


def _power(exponent: int) -> str:
    if -2 <= exponent <= 4:
        return f"{10.0**exponent:g}"
    return "10" + str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def line(frame: Frame, x: FloatArray, y: FloatArray, style: str) -> str:
    """Return a curve, interrupted where y is nan."""
    return f'<path class="{style}" d="{_path(frame, x, y)}"/>'


def area(frame: Frame, x: FloatArray, lower: FloatArray, upper: FloatArray, style: str) -> str:
    """Return the area between two curves."""
    valid = np.isfinite(lower) & np.isfinite(upper)
    upper_edge = _points(frame, x[valid], upper[valid])
    lower_edge = _points(frame, x[valid][::-1], lower[valid][::-1])
    return f'<polygon class="{style}" points="{" ".join(upper_edge + lower_edge)}"/>'


def level(frame: Frame, y: float, style: str) -> str:
    """Return a horizontal line across the chart."""
    return line(frame, np.array([frame.x.lower, frame.x.upper]), np.array([y, y]), style)


def bars(names: Sequence[str], values: Sequence[Sequence[float]], styles: Sequence[str], axis: Axis) -> str:
    """Return a chart of horizontal bars in named groups.

    Parameters
    ----------
    names
        Name of each group.
    values
        Values of each group, one for each style, on the scale of the axis; bars start at its lower limit.
    """
    thickness, name_height, gap = 13.0, 20.0, 4.0
    group = name_height + thickness * len(styles) + gap
    frame = Frame(axis, axis, height=MARGIN["top"] + group * len(names) + MARGIN["bottom"])
    start = MARGIN["left"]
    parts = [_grid_across(frame)]
    for i, (name, numbers) in enumerate(zip(names, values, strict=True)):
        top = MARGIN["top"] + i * group
        parts.append(f'<text class="name" x="{start:.1f}" y="{top + 12:.1f}">{escape(name)}</text>')
        for j, (number, style) in enumerate(zip(numbers, styles, strict=True)):
            end = float(frame.across(np.array(number)))
            bar_top = top + name_height + j * thickness - 3
            parts.append(rectangle(start, bar_top, max(end - start, 1.0), thickness - 2, style))
    return drawing(frame.width, frame.height, "gap by step", parts)


def rectangle(x: float, y: float, width: float, height: float, style: str) -> str:
    """Return a filled rectangle."""
    return f'<rect class="{style}" x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"/>'


def text(x: float, y: float, words: str, style: str) -> str:
    """Return a text at a position."""
    return f'<text class="{style}" x="{x:.1f}" y="{y:.1f}">{escape(words)}</text>'


def dots(frame: Frame, x: FloatArray, y: FloatArray, style: str) -> str:
    """Return a dot for every point with a finite y."""
    good = np.isfinite(y)
    places = zip(frame.across(x[good]), frame.down(y[good]), strict=True)
    return "".join(f'<circle class="{style}" cx="{a:.1f}" cy="{b:.1f}" r="2.2"/>' for a, b in places)


def spans(frame: Frame, x: FloatArray, lower: FloatArray, upper: FloatArray, style: str) -> str:
    """Return a vertical bar between two values at every x."""
    good = np.isfinite(lower) & np.isfinite(upper)
    places = zip(frame.across(x[good]), frame.down(lower[good]), frame.down(upper[good]), strict=True)
    return f'<path class="{style}" d="{"".join(f"M{a:.1f},{b:.1f}V{c:.1f}" for a, b, c in places)}"/>'


def chart(frame: Frame, title: str, marks: Sequence[str]) -> str:
    """Return a chart: grid with axes, and marks."""
    grid = [_grid_across(frame), _grid_up(frame)]
    return drawing(frame.width, frame.height, title, [*grid, *marks])


def thinned(
    x: FloatArray, curves: Sequence[FloatArray], points: int = 700
) -> tuple[FloatArray, list[FloatArray]]:
    """Return curves with fewer points, which keep the minimum and maximum of every block of lines."""
    stretch = 2 * len(x) // points
    if stretch < 2:
        return x, list(curves)
    n = len(x) // stretch * stretch
    keep = np.zeros(len(x), bool)
    keep[n:] = True
    starts = np.arange(0, n, stretch)
    for curve in curves:
        blocks = np.nan_to_num(curve[:n]).reshape(-1, stretch)
        keep[starts + blocks.argmin(axis=1)] = True
        keep[starts + blocks.argmax(axis=1)] = True
    return x[keep], [curve[keep] for curve in curves]


def drawing(width: float, height: float, title: str, parts: Sequence[str]) -> str:
    """Return a drawing with a title for screen readers."""
    name = escape(title)
    return (
        f'<svg viewBox="0 0 {width:g} {height:g}" role="img" aria-label="{name}">'
        f"<title>{name}</title>{''.join(parts)}</svg>"
    )


def _points(frame: Frame, x: FloatArray, y: FloatArray) -> list[str]:
    return [f"{a:.1f},{b:.1f}" for a, b in zip(frame.across(x), frame.down(y), strict=True)]


def _path(frame: Frame, x: FloatArray, y: FloatArray) -> str:
    good = np.isfinite(y)
    pieces = np.split(np.arange(len(x)), np.flatnonzero(np.diff(good)) + 1)
    polylines = [_points(frame, x[p], y[p]) for p in pieces if len(p) and good[p[0]]]
    return "".join("M" + "L".join(points) for points in polylines)


def _grid_across(frame: Frame) -> str:
    parts = []
    for value, words in frame.x.ticks:
        place = float(frame.across(np.array(value)))
        parts.append(f'<path class="grid" d="M{place:.1f},{MARGIN["top"]:g}V{frame.bottom:.1f}"/>')
        if frame.x.label:
            parts.append(text(place, frame.bottom + 16, words, "tick"))
    if frame.x.label:
        middle = (MARGIN["left"] + frame.width - MARGIN["right"]) / 2
        parts.append(text(middle, frame.height - 5, frame.x.label, "label"))
    return "".join(parts)


def _grid_up(frame: Frame) -> str:
    start, end = MARGIN["left"], frame.width - MARGIN["right"]
    parts = []
    for value, words in frame.y.ticks:
        place = float(frame.down(np.array(value)))
        parts.append(f'<path class="grid" d="M{start:g},{place:.1f}H{end:g}"/>')
        parts.append(f'<text class="side" x="{start - 6:g}" y="{place + 4:.1f}">{escape(words)}</text>')
    middle = (MARGIN["top"] + frame.bottom) / 2
    rotation = f'transform="translate(14,{middle:.1f}) rotate(-90)"'
    parts.append(f'<text class="label" {rotation}>{escape(frame.y.label)}</text>')
    return "".join(parts)
