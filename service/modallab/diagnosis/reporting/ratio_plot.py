"""Drawing of the ratio measured over predicted, for differences too small for an FRF curve."""

from html import escape

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.diagnosis.reporting import svg
from modallab.diagnosis.reporting.legend import legend
from modallab.diagnosis.reporting.settings import DRAWING, REPORT
from modallab.diagnosis.result_curves import FrfCurves


def ratio_drawing(curves: FrfCurves, i: int, *, added: bool) -> str:
    """Return the ratio of one FRF to its initial prediction, magnitude in per cent and phase in degrees."""
    error = curves.random_error[:, i]
    sizes = np.minimum(np.abs(curves.measured[:, i]), np.abs(curves.before[:, i]))
    lines = np.flatnonzero((curves.freq > 0) & (sizes > 0))
    lines = lines[error[lines] <= REPORT.poor_line * np.median(error[lines])]
    lines = lines[:: -(-len(lines) // DRAWING.ratio_dots)]
    initial = curves.before[lines, i]
    measured, final = curves.measured[lines, i] / initial, curves.after[lines, i] / initial
    freq, spread, name = curves.freq[lines], error[lines], curves.name(i)
    parts = (
        ("magnitude, %", 100 * (np.abs(measured) - 1), 100 * (np.abs(final) - 1), 200 * spread),
        (
            "phase, degrees",
            np.degrees(np.angle(measured)),
            np.degrees(np.angle(final)),
            np.degrees(2 * spread),
        ),
    )
    pictures = [
        _chart(curves, freq, part, f"{part[0]} of {name} over the initial prediction", added)
        for part in parts
    ]
    remark = ", held out of every fit" if curves.held_out[i] else ""
    caption = (
        f"Response {name}{remark}: measured over initial prediction. Dots: measured lines; bars: ± 2 random "
        "errors; lines with large random errors are omitted."
    )
    return (
        f'<h2>Largest difference</h2><p class="soft">{legend(added)}</p>'
        f'<div class="two">{"".join(pictures)}</div><p class="soft">{escape(caption)}</p>'
    )


def _chart(
    curves: FrfCurves,
    freq: FloatArray,
    part: tuple[str, FloatArray, FloatArray, FloatArray],
    title: str,
    added: bool,
) -> str:
    label, measured, final, spread = part
    values = np.concatenate([measured, final, spread, -spread])
    low, high = (
        DRAWING.ratio_margin * min(float(values.min()), -COMPARISON_ROUNDING),
        DRAWING.ratio_margin * max(float(values.max()), COMPARISON_ROUNDING),
    )
    frame = svg.Frame(svg.frequencies(curves.freq), svg.linear(low, high, label, n_ticks=5), height=230.0)
    marks = [
        svg.level(frame, 0.0, "before"),
        svg.spans(frame, freq, measured - spread, measured + spread, "haze"),
        svg.dots(frame, freq, measured, "dot"),
        svg.line(frame, freq, final, "after") if added else "",
    ]
    return f"<figure>{svg.chart(frame, title, marks)}</figure>"
