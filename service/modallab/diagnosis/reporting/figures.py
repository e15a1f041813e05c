"""The curves of a report: FRFs measured and predicted, and how far apart they are in random errors."""

from collections.abc import Sequence
from dataclasses import replace
from html import escape

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.diagnosis.reporting import svg
from modallab.diagnosis.reporting.legend import legend
from modallab.diagnosis.reporting.ratio_plot import ratio_drawn
from modallab.diagnosis.reporting.residual_plot import POINTS, differences
from modallab.diagnosis.result_curves import Curves

MOST_ERROR = 0.9  # of |H|, relative, that a band on a logarithmic axis can show
SEEN = 3.0  # random errors beyond which a difference is worth an enlargement
NEAR = 0.15  # of the largest difference, up to which an enlargement reaches
SLIGHT = 0.3  # |ln(measured / predicted)| that cannot be seen on an axis of decibels
FEWEST, MOST = 10, 60  # lines on each side of the largest difference


def all_curves(curves: Curves, *, added: bool) -> str:
    """Return drawings of the FRFs that tell most, and of what was predicted without a measurement.

    Parameters
    ----------
    added
        Whether anything was added; if not, before and after are the same curve.
    """
    figures = [_channel(curves, channel, why, added) for channel, why in telling(curves).items()]
    if curves.predicted is not None:
        figures += [_unmeasured(curves, i) for i in range(min(2, len(curves.predicted_outputs)))]
    return f'<h2>Curves</h2><p class="soft">{legend(added)}</p><div class="two">{"".join(figures)}</div>'


def telling(curves: Curves) -> dict[int, str]:
    """Return the channels worth a look, each with the reason: drive point, worst fitted, worst held out."""
    apart = (residual(curves, curves.before) ** 2)[1:].mean(axis=(0, 2))
    chosen: dict[int, str] = {}
    for i, dof in enumerate(curves.outputs):
        if dof.point == curves.inputs[0].point:
            chosen[i] = "drive point"
    for group, why in ((~curves.held_out, "worst of the fitted"), (curves.held_out, "held out of every fit")):
        rest = [i for i in np.flatnonzero(group) if i not in chosen]
        if rest:
            chosen[int(max(rest, key=lambda i: apart[i]))] = why
    return chosen


def residual(curves: Curves, predicted: ComplexArray) -> FloatArray:
    """Return |ln(measured / predicted)| in random errors of a complex logarithm."""
    ratio = np.log(np.where(_good(curves), curves.measured, 1.0) / np.where(_good(curves), predicted, 1.0))
    return np.asarray(np.abs(ratio) / (np.sqrt(2) * curves.random_error))


def _good(curves: Curves) -> BoolArray:
    # Zeros have no logarithm, and at rest there is rounding and nothing else.
    sizes = np.minimum(np.minimum(np.abs(curves.measured), np.abs(curves.before)), np.abs(curves.after))
    return np.asarray((curves.freq > 0)[:, None, None] & (sizes > 0))


def clearest(curves: Curves) -> tuple[int, IntArray] | None:
    """Return the channel and the lines where the prediction as given is furthest off, if it is at all.

    A channel that took no part in the fits is preferred: there the prediction is put to the test.
    """
    apart = np.where(_good(curves)[:, :, 0], residual(curves, curves.before)[:, :, 0], 0.0)
    held = curves.held_out & (apart.max(axis=0) > 2 * SEEN)
    group = np.flatnonzero(held if held.any() else ~curves.held_out)
    channel = int(group[apart[:, group].max(axis=0).argmax()])
    off = np.convolve(apart[:, channel], np.ones(3) / 3, mode="same")
    peak = int(off.argmax())
    if off[peak] < SEEN:
        return None
    far = np.flatnonzero(off < max(NEAR * off[peak], SEEN))
    below, above = far[far < peak], far[far > peak]
    # What is off everywhere is not enlarged by showing it all.
    most = min(max(FEWEST, len(off) // 8), MOST)
    first = max(peak - most, min(peak - FEWEST, int(below[-1]) - 2 if below.size else 0), 1)
    last = min(peak + most, max(peak + FEWEST, int(above[0]) + 2 if above.size else len(off)))
    return channel, np.arange(first, min(last + 1, len(off)))


def enlarged(curves: Curves, *, added: bool) -> str:
    """Return the stretch of one FRF where the prediction as given is furthest off, line by line.

    What is too little to be seen there is shown as a ratio instead.
    """
    found = clearest(curves)
    if found is None:
        return ""
    i, lines = found
    apart = np.log(curves.measured[lines, i, 0] / curves.before[lines, i, 0])
    if np.abs(apart).max() < SLIGHT:
        return ratio_drawn(curves, i, added=added)
    part = replace(
        curves,
        freq=curves.freq[lines],
        predicted=None,
        predicted_outputs=(),
        **{name: getattr(curves, name)[lines] for name in ("measured", "before", "after", "random_error")},
    )
    name = _name(curves, i)
    across = svg.frequencies(part.freq)
    good = _good(part)[:, i, 0]
    pictures = []
    for quantity in (_size(part, i, good), _turn(part, i, good)):
        frame = replace(quantity.frame, x=across, height=230.0)
        marks = [svg.line(frame, part.freq, quantity.before, "before")]
        marks += [svg.line(frame, part.freq, quantity.after, "after")] if added else []
        marks += [
            svg.spans(frame, part.freq, quantity.low, quantity.high, "bar"),
            svg.dots(frame, part.freq, quantity.measured, "dot"),
        ]
        pictures.append(f"<figure>{svg.chart(frame, f'{quantity.name} of {name}, enlarged', marks)}</figure>")
    why = "which took no part in any fit" if curves.held_out[i] else "as fitted"
    words = (
        f"Response {name}, {why}, where the prediction as given is far off. Dots are measured lines, "
        "the bars at them ± 2 random errors."
    )
    return (
        f'<h2>The clearest difference</h2><p class="soft">{legend(added)}</p>'
        f'<div class="two">{"".join(pictures)}</div><p class="soft">{escape(words)}</p>'
    )


class _Quantity:
    """Magnitude or phase of one FRF, with its band of random error."""

    def __init__(
        self,
        name: str,
        curves: tuple[FloatArray, FloatArray, FloatArray],
        error: tuple[FloatArray, FloatArray],
    ) -> None:
        self.name = name
        self.measured, self.before, self.after = curves
        self.low, self.high = (self.measured + one for one in error)
        self.frame = svg.Frame(svg.linear(0.0, 1.0, ""), _axis_of(name, curves))


def _axis_of(name: str, shown: Sequence[FloatArray]) -> svg.Axis:
    if name == "phase":
        quarters = tuple((float(a), f"{a}") for a in (-180, -90, 0, 90, 180))
        return svg.Axis(-190.0, 190.0, quarters, "phase, degrees")
    drawn = np.concatenate(shown)
    drawn = drawn[np.isfinite(drawn)] if np.isfinite(drawn).any() else np.zeros(1)
    low, high = np.floor(drawn.min() / 5) * 5, np.ceil((drawn.max() + 0.1) / 5) * 5
    return svg.linear(low, high, "dB re 1 m/(s² N)", n_ticks=5)


def _size(curves: Curves, i: int, good: BoolArray) -> _Quantity:
    error = np.minimum(2 * curves.random_error[:, i, 0], MOST_ERROR)
    drawn = [_decibel(values[:, i, 0], good) for values in (curves.measured, curves.before, curves.after)]
    return _Quantity(
        "magnitude",
        (drawn[0], drawn[1], drawn[2]),
        (20 * np.log10(1 - error), 20 * np.log10(1 + error)),
    )


def _turn(curves: Curves, i: int, good: BoolArray) -> _Quantity:
    error = np.degrees(2 * curves.random_error[:, i, 0])
    drawn = [
        np.where(good, np.degrees(np.angle(values[:, i, 0])), np.nan)
        for values in (curves.measured, curves.before, curves.after)
    ]
    return _Quantity("phase", (drawn[0], drawn[1], drawn[2]), (-error, error))


def _channel(curves: Curves, i: int, why: str, added: bool) -> str:
    good = _good(curves)[:, i, 0]
    name = _name(curves, i)
    pictures = []
    for quantity, height in ((_size(curves, i, good), 190.0), (_turn(curves, i, good), 110.0)):
        bare = svg.linear(float(curves.freq[0]), float(curves.freq[-1]), "")
        frame = replace(quantity.frame, x=bare, height=height)  # frequencies are named below the errors
        shown = [quantity.measured, quantity.before, quantity.after, quantity.low, quantity.high]
        x, (measured, before, after, low, high) = svg.thinned(curves.freq, shown, POINTS)
        if quantity.name == "phase":
            measured, before, after = map(_unjumped, (measured, before, after))
        marks = [
            svg.area(frame, x, low, high, "noise") if quantity.name == "magnitude" else "",
            svg.line(frame, x, before, "before"),
            svg.line(frame, x, measured, "measured"),
            svg.line(frame, x, after, "after") if added else "",
        ]
        pictures.append(svg.chart(frame, f"{quantity.name} of {name}", marks))
    words = f"Response {name}, {why}: magnitude, phase, and how far off the prediction is in random errors."
    pictures.append(_errors(curves, i, good, name, added))
    return f"<figure>{''.join(pictures)}<figcaption>{escape(words)}</figcaption></figure>"


def _name(curves: Curves, i: int) -> str:
    return f"{curves.outputs[i]} / {curves.inputs[0]}"


def _unjumped(phase: FloatArray) -> FloatArray:
    """Return a phase without the lines that a jump from -180 to 180 degrees would draw."""
    jumps = np.flatnonzero(np.abs(np.diff(phase)) > 180)
    broken = phase.copy()
    broken[jumps] = np.nan
    return broken


def _errors(curves: Curves, i: int, good: BoolArray, name: str, added: bool) -> str:
    before, after = (
        np.where(good, residual(curves, predicted)[:, i, 0], np.nan)
        for predicted in (curves.before, curves.after)
    )
    return differences(curves.freq, before, after, f"difference of {name} in random errors", added)


def _unmeasured(curves: Curves, i: int) -> str:
    assert curves.predicted is not None
    values = curves.predicted[:, i, 0]
    predicted = _decibel(values, (np.abs(values) > 0) & (curves.freq > 0))
    x, (thin,) = svg.thinned(curves.freq, [predicted], POINTS)
    frame = svg.Frame(svg.frequencies(curves.freq), _axis_of("magnitude", (thin,)))
    name = f"{curves.predicted_outputs[i]} / {curves.inputs[0]}"
    picture = svg.chart(frame, f"magnitude of {name}, predicted", [svg.line(frame, x, thin, "after")])
    words = f"Response {name}, not measured: predicted."
    return f"<figure>{picture}<figcaption>{escape(words)}</figcaption></figure>"


def _decibel(values: ComplexArray, good: BoolArray) -> FloatArray:
    return np.asarray(20 * np.log10(np.where(good, np.abs(values), np.nan)))
