"""The curves of a report: FRFs measured and predicted, and how far apart they are in random errors."""

from collections.abc import Sequence
from dataclasses import replace
from html import escape

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.diagnosis import svg
from modallab.diagnosis.result import Curves


def all_curves(curves: Curves) -> str:
    """Return drawings of the FRFs that tell most, and of what was predicted without a measurement."""
    legend = keys(
        (
            ("measured", "measured"),
            ("noise", "± 2 random errors"),
            ("before", "predicted as given"),
            ("after", "with what was added"),
        )
    )
    figures = [_channel(curves, channel, why) for channel, why in telling(curves).items()]
    if curves.predicted is not None:
        figures += [_unmeasured(curves, i) for i in range(min(2, len(curves.predicted_outputs)))]
    return f"<h2>Curves</h2><p class='kicker'>{legend}</p>{''.join(figures)}"


def keys(pairs: Sequence[tuple[str, str]]) -> str:
    """Return the legend of a drawing: style and text of each mark."""
    return "".join(f'<span class="key {style}"></span>{escape(text)}' for style, text in pairs)


def telling(curves: Curves) -> dict[int, str]:
    """Return the channels worth a look, each with the reason: drive point, worst fitted, worst held out."""
    apart = (_residual(curves, curves.before) ** 2)[1:].mean(axis=(0, 2))
    chosen: dict[int, str] = {}
    for i, dof in enumerate(curves.outputs):
        if dof.point == curves.inputs[0].point:
            chosen[i] = "drive point"
    for group, why in ((~curves.held_out, "worst of the fitted"), (curves.held_out, "held out of every fit")):
        rest = [i for i in np.flatnonzero(group) if i not in chosen]
        if rest:
            chosen[int(max(rest, key=lambda i: apart[i]))] = why
    return chosen


def _residual(curves: Curves, predicted: ComplexArray) -> FloatArray:
    """Return |ln(measured / predicted)| in random errors of a complex logarithm."""
    ratio = np.log(np.where(_good(curves), curves.measured, 1.0) / np.where(_good(curves), predicted, 1.0))
    return np.asarray(np.abs(ratio) / (np.sqrt(2) * curves.random_error))


def _good(curves: Curves) -> BoolArray:
    # Zeros have no logarithm, and at rest there is rounding and nothing else.
    sizes = np.minimum(np.minimum(np.abs(curves.measured), np.abs(curves.before)), np.abs(curves.after))
    return np.asarray((curves.freq > 0)[:, None, None] & (sizes > 0))


def _channel(curves: Curves, i: int, why: str) -> str:
    good = _good(curves)[:, i, 0]
    measured, before, after = (
        _decibel(values[:, i, 0], good) for values in (curves.measured, curves.before, curves.after)
    )
    error = np.minimum(2 * curves.random_error[:, i, 0], 0.9)
    low, high = measured + 20 * np.log10(1 - error), measured + 20 * np.log10(1 + error)
    x, (measured, before, after, low, high) = svg.thinned(curves.freq, [measured, before, after, low, high])
    # The frequencies are named once, below the errors.
    frame = replace(_frame(curves.freq, (measured, before, after)), x=_frequencies(curves.freq, ""))
    marks = [
        svg.area(frame, x, low, high, "noise"),
        svg.line(frame, x, before, "before"),
        svg.line(frame, x, measured, "measured"),
        svg.line(frame, x, after, "after"),
    ]
    name = f"{curves.outputs[i]} / {curves.inputs[0]}"
    picture = svg.chart(frame, f"inertance {name}", marks)
    return (
        f"<figure>{picture}{_errors(curves, i, good, name)}"
        f"<figcaption>Response {escape(name)}, {why}: inertance above, below it how far the "
        "prediction is from the measurement in random errors.</figcaption></figure>"
    )


def _errors(curves: Curves, i: int, good: BoolArray, name: str) -> str:
    off = [
        np.where(good, np.log10(np.maximum(_residual(curves, predicted)[:, i, 0], 1e-2)), np.nan)
        for predicted in (curves.before, curves.after)
    ]
    x, (before, after) = svg.thinned(curves.freq, off)
    top = max(1.0, float(np.nanmax(np.concatenate([before, after]), initial=1.0)))
    frame = svg.Frame(_frequencies(curves.freq), svg.decades(-1.0, top, "random errors"), height=150.0)
    marks = [
        svg.line(frame, x, before, "before"),
        svg.line(frame, x, after, "left"),
        svg.level(frame, 0.0, "one"),
    ]
    return svg.chart(frame, f"residual {name}", marks)


def _unmeasured(curves: Curves, i: int) -> str:
    assert curves.predicted is not None
    values = curves.predicted[:, i, 0]
    predicted = _decibel(values, (np.abs(values) > 0) & (curves.freq > 0))
    x, (thin,) = svg.thinned(curves.freq, [predicted])
    frame = _frame(curves.freq, (thin,))
    name = f"{curves.predicted_outputs[i]} / {curves.inputs[0]}"
    picture = svg.chart(frame, f"inertance {name}", [svg.line(frame, x, thin, "after")])
    words = f"Response {name}, not measured: predicted."
    return f"<figure>{picture}<figcaption>{escape(words)}</figcaption></figure>"


def _decibel(values: ComplexArray, good: BoolArray) -> FloatArray:
    return np.asarray(20 * np.log10(np.where(good, np.abs(values), np.nan)))


def _frame(freq: FloatArray, shown: Sequence[FloatArray]) -> svg.Frame:
    drawn = np.concatenate(shown)
    drawn = drawn[np.isfinite(drawn)] if np.isfinite(drawn).any() else np.zeros(1)
    label = "dB re 1 m/(s² N)"
    vertical = svg.linear(np.floor(drawn.min() / 5) * 5, np.ceil((drawn.max() + 0.1) / 5) * 5, label)
    return svg.Frame(_frequencies(freq), vertical, height=230.0)


def _frequencies(freq: FloatArray, label: str = "frequency, Hz") -> svg.Axis:
    return svg.linear(float(freq[0]), float(freq[-1]), label, n_ticks=10)
