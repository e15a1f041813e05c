"""Measured over predicted, for differences that no curve of an FRF shows."""

from html import escape

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.reporting import svg
from modallab.diagnosis.reporting.legend import legend
from modallab.diagnosis.result_curves import Curves

DOTS = 200  # lines that are drawn, at most
SURE = 3.0  # typical random errors beyond which a line is left out
ROOM = 1.3  # of the axis, over the largest difference


def ratio_drawn(curves: Curves, i: int, *, added: bool) -> str:
    """Return how one FRF differs from its prediction, in per cent and in degrees, over frequency."""
    error = curves.random_error[:, i, 0]
    sizes = np.minimum(np.abs(curves.measured[:, i, 0]), np.abs(curves.before[:, i, 0]))
    good = np.flatnonzero((curves.freq > 0) & (sizes > 0))
    good = good[error[good] <= SURE * np.median(error[good])]
    good = good[:: -(-len(good) // DOTS)]
    before = curves.before[good, i, 0]
    measured, after = curves.measured[good, i, 0] / before, curves.after[good, i, 0] / before
    freq, spread, name = curves.freq[good], error[good], f"{curves.outputs[i]} / {curves.inputs[0]}"
    parts = (
        ("magnitude, %", 100 * (np.abs(measured) - 1), 100 * (np.abs(after) - 1), 200 * spread),
        (
            "phase, degrees",
            np.degrees(np.angle(measured)),
            np.degrees(np.angle(after)),
            np.degrees(2 * spread),
        ),
    )
    pictures = [
        _one(curves, freq, part, f"{part[0]} of {name} against the prediction", added) for part in parts
    ]
    held = ", which took no part in any fit" if curves.held_out[i] else ""
    words = (
        f"Response {name}{held}: measured over predicted as given. Dots are measured lines, the bars at them "
        "± 2 random errors; lines that are known less well are left out."
    )
    return (
        f'<h2>The clearest difference</h2><p class="soft">{legend(added)}</p>'
        f'<div class="two">{"".join(pictures)}</div><p class="soft">{escape(words)}</p>'
    )


def _one(
    curves: Curves,
    freq: FloatArray,
    part: tuple[str, FloatArray, FloatArray, FloatArray],
    title: str,
    added: bool,
) -> str:
    label, measured, after, spread = part
    shown = np.concatenate([measured, after, spread, -spread])
    low, high = ROOM * min(float(shown.min()), -1e-9), ROOM * max(float(shown.max()), 1e-9)
    frame = svg.Frame(svg.frequencies(curves.freq), svg.linear(low, high, label, n_ticks=5), height=230.0)
    marks = [
        svg.level(frame, 0.0, "before"),
        svg.spans(frame, freq, measured - spread, measured + spread, "haze"),
        svg.dots(frame, freq, measured, "dot"),
        svg.line(frame, freq, after, "after") if added else "",
    ]
    return f"<figure>{svg.chart(frame, title, marks)}</figure>"
