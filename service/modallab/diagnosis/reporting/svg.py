"""Curves and bars as SVG by hand: small, sharp in print, coloured by the page that holds them."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from modallab.core.arrays import FloatArray

MARGIN = {"left": 58.0, "right": 20.0, "top": 8.0, "bottom": 40.0}
WIDTH = 480.0  # of a drawing: about that of a phone, and of half a page on a desk
BARE = 12.0  # below a drawing whose horizontal axis is that of the next one
STEPS = (1.0, 2.0, 5.0, 10.0)  # of ticks, times a power of ten


@dataclass(frozen=True)
class Axis:
    """A stretch of numbers, where its ticks are and what they say."""

    lower: float
    upper: float
    ticks: tuple[tuple[float, str], ...]
    label: str

    def at(self, values: FloatArray) -> FloatArray:
        """Return how far along the axis values are, 0 to 1; what lies beyond is put on its end."""
        share = (values - self.lower) / (self.upper - self.lower)
        return np.asarray(np.clip(share, 0.0, 1.0))


@dataclass(frozen=True)
class Frame:
    """A drawing with two axes; one without a horizontal label stands upon another with the same axis."""

    x: Axis
    y: Axis
    width: float = WIDTH
    height: float = 220.0

    @property
    def bottom(self) -> float:
        """Where the drawing's area ends."""
        return self.height - (MARGIN["bottom"] if self.x.label else BARE)

    def across(self, x: FloatArray) -> FloatArray:
        """Return horizontal places in the drawing."""
        room = self.width - MARGIN["left"] - MARGIN["right"]
        return np.asarray(MARGIN["left"] + room * self.x.at(x))

    def down(self, y: FloatArray) -> FloatArray:
        """Return vertical places in the drawing."""
        room = self.bottom - MARGIN["top"]
        return np.asarray(MARGIN["top"] + room * (1.0 - self.y.at(y)))


def linear(lower: float, upper: float, label: str, *, n_ticks: int = 6) -> Axis:
    """Return an axis with round ticks between the limits."""
    span = max(upper - lower, 1e-12)
    power = 10.0 ** np.floor(np.log10(span / n_ticks))
    step = next(s * power for s in STEPS if s * power * n_ticks >= span)
    first = np.ceil(lower / step - 1e-9) * step
    values = np.arange(first, upper + 1e-9 * span, step)
    return Axis(lower, lower + span, tuple((float(v), f"{v + 0.0:.10g}") for v in values.round(12)), label)


def frequencies(freq: FloatArray) -> Axis:
    """Return the axis of frequencies."""
    return linear(float(freq[0]), float(freq[-1]), "frequency, Hz", n_ticks=6)


def decades(lower: float, upper: float, label: str) -> Axis:
    """Return an axis of logarithms to base ten, limits rounded outward to whole decades."""
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
    """Return a curve; it breaks where y is not a number."""
    return f'<path class="{style}" d="{_path(frame, x, y)}"/>'


def area(frame: Frame, x: FloatArray, lower: FloatArray, upper: FloatArray, style: str) -> str:
    """Return the area between two curves."""
    good = np.isfinite(lower) & np.isfinite(upper)
    there = _points(frame, x[good], upper[good])
    back = _points(frame, x[good][::-1], lower[good][::-1])
    return f'<polygon class="{style}" points="{" ".join(there + back)}"/>'


def level(frame: Frame, y: float, style: str) -> str:
    """Return a line across the whole drawing."""
    return line(frame, np.array([frame.x.lower, frame.x.upper]), np.array([y, y]), style)


def bars(names: Sequence[str], values: Sequence[Sequence[float]], styles: Sequence[str], axis: Axis) -> str:
    """Return a drawing of horizontal bars: a name over each group, in it a bar a style.

    `values` holds for each name one number a style, on the axis's own scale; bars start at its lower end.
    """
    thick, above = 13.0, 20.0
    group = above + thick * len(styles) + 4.0
    frame = Frame(axis, axis, height=MARGIN["top"] + group * len(names) + MARGIN["bottom"])
    left = MARGIN["left"]
    parts = [_grid_across(frame)]
    for i, (name, numbers) in enumerate(zip(names, values, strict=True)):
        top = MARGIN["top"] + i * group
        parts.append(f'<text class="name" x="{left:.1f}" y="{top + 12:.1f}">{escape(name)}</text>')
        for j, (number, style) in enumerate(zip(numbers, styles, strict=True)):
            end = float(frame.across(np.array(number)))
            parts.append(rectangle(left, top + above + j * thick - 3, max(end - left, 1.0), thick - 2, style))
    return drawing(frame.width, frame.height, "gap by step", parts)


def rectangle(x: float, y: float, width: float, height: float, style: str) -> str:
    """Return a filled rectangle."""
    return f'<rect class="{style}" x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"/>'


def text(x: float, y: float, words: str, style: str) -> str:
    """Return words at a place."""
    return f'<text class="{style}" x="{x:.1f}" y="{y:.1f}">{escape(words)}</text>'


def dots(frame: Frame, x: FloatArray, y: FloatArray, style: str) -> str:
    """Return a dot for every pair that is a number."""
    good = np.isfinite(y)
    places = zip(frame.across(x[good]), frame.down(y[good]), strict=True)
    return "".join(f'<circle class="{style}" cx="{a:.1f}" cy="{b:.1f}" r="2.2"/>' for a, b in places)


def spans(frame: Frame, x: FloatArray, lower: FloatArray, upper: FloatArray, style: str) -> str:
    """Return an upright line from one number to another at every x."""
    good = np.isfinite(lower) & np.isfinite(upper)
    places = zip(frame.across(x[good]), frame.down(lower[good]), frame.down(upper[good]), strict=True)
    return f'<path class="{style}" d="{"".join(f"M{a:.1f},{b:.1f}V{c:.1f}" for a, b, c in places)}"/>'


def chart(frame: Frame, title: str, marks: Sequence[str]) -> str:
    """Return a drawing: axes with their grid, and the marks upon them."""
    grid = [_grid_across(frame), _grid_up(frame)]
    return drawing(frame.width, frame.height, title, [*grid, *marks])


def thinned(
    x: FloatArray, curves: Sequence[FloatArray], points: int = 700
) -> tuple[FloatArray, list[FloatArray]]:
    """Return curves with fewer points, their peaks and notches kept: both extremes of every stretch."""
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
    """Return a drawing that a screen reader tells by its title."""
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
    drawn = [_points(frame, x[p], y[p]) for p in pieces if len(p) and good[p[0]]]
    return "".join("M" + "L".join(points) for points in drawn)


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
    left, right = MARGIN["left"], frame.width - MARGIN["right"]
    parts = []
    for value, words in frame.y.ticks:
        place = float(frame.down(np.array(value)))
        parts.append(f'<path class="grid" d="M{left:g},{place:.1f}H{right:g}"/>')
        parts.append(f'<text class="side" x="{left - 6:g}" y="{place + 4:.1f}">{escape(words)}</text>')
    middle = (MARGIN["top"] + frame.bottom) / 2
    turned = f'transform="translate(14,{middle:.1f}) rotate(-90)"'
    parts.append(f'<text class="label" {turned}>{escape(frame.y.label)}</text>')
    return "".join(parts)
