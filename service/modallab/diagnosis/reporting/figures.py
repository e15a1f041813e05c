"""Drawings of measured and predicted FRFs, and of their residual in random errors."""

from collections.abc import Sequence
from dataclasses import replace
from html import escape

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.diagnosis.reporting import svg
from modallab.diagnosis.reporting.legend import legend
from modallab.diagnosis.reporting.ratio_plot import ratio_drawing
from modallab.diagnosis.reporting.residual_plot import residual_chart
from modallab.diagnosis.reporting.settings import DRAWING, REPORT
from modallab.diagnosis.result_curves import DiagnosisCurves, FrfCurves


def all_curves(curves: DiagnosisCurves, *, added: bool) -> str:
    """Return drawings of the most informative FRFs and of those predicted without a measurement.

    Parameters
    ----------
    added
        Whether effects were added; if not, initial and final prediction are the same curve.
    """
    shown = shown_channels(curves).items()
    figures = [_channel(curves.by_frf, channel, why, added) for channel, why in shown]
    if curves.predicted is not None:
        figures += [_unmeasured(curves, i) for i in range(min(2, len(curves.predicted_outputs)))]
    return f'<h2>Curves</h2><p class="soft">{legend(added)}</p><div class="two">{"".join(figures)}</div>'


def shown_channels(curves: DiagnosisCurves) -> dict[int, str]:
    """Return the channels to draw, each with the reason: drive point, worst fitted, worst held out."""
    frfs = curves.by_frf
    mean_square = (residual(frfs, frfs.before) ** 2)[1:].mean(axis=0)
    reasons: dict[int, str] = {}
    at_drive = [i for i, dof in enumerate(frfs.outputs) if dof.point == frfs.inputs[i].point]
    if at_drive:
        reasons[max(at_drive, key=lambda i: mean_square[i])] = "drive point"
    for group, reason in (
        (~frfs.held_out, "largest residual of the fitted responses"),
        (frfs.held_out, "largest residual of the held-out responses"),
    ):
        candidates = [i for i in np.flatnonzero(group) if i not in reasons]
        if candidates:
            reasons[int(max(candidates, key=lambda i: mean_square[i]))] = reason
    return reasons


def residual(curves: FrfCurves, predicted: ComplexArray) -> FloatArray:
    """Return |ln(measured / predicted)| over its random error, (n_freq, n_frf)."""
    ratio = np.log(np.where(_valid(curves), curves.measured, 1.0) / np.where(_valid(curves), predicted, 1.0))
    return np.asarray(np.abs(ratio) / (np.sqrt(2) * curves.random_error))


def _valid(curves: FrfCurves) -> BoolArray:
    # Zeros have no logarithm; at 0 Hz an inertance is rounding alone.
    sizes = np.minimum(np.minimum(np.abs(curves.measured), np.abs(curves.before)), np.abs(curves.after))
    return np.asarray((curves.freq > 0)[:, None] & (sizes > 0))


def largest_difference(curves: DiagnosisCurves) -> tuple[int, IntArray] | None:
    """Return channel and lines of the largest difference of the initial prediction; None if it is small.

    A held-out channel is preferred, because it tests the prediction independently of the fits.
    """
    frfs = curves.by_frf
    difference = np.where(_valid(frfs), residual(frfs, frfs.before), 0.0)
    outlying = frfs.held_out & (difference.max(axis=0) > 2 * REPORT.visible_difference)
    group = np.flatnonzero(outlying if outlying.any() else ~frfs.held_out)
    channel = int(group[difference[:, group].max(axis=0).argmax()])
    smooth = np.convolve(difference[:, channel], np.ones(3) / 3, mode="same")
    peak = int(smooth.argmax())
    if smooth[peak] < REPORT.visible_difference:
        return None
    quiet = np.flatnonzero(smooth < max(REPORT.enlargement_level * smooth[peak], REPORT.visible_difference))
    lower, upper = quiet[quiet < peak], quiet[quiet > peak]
    reach = min(max(REPORT.fewest_lines, len(smooth) // REPORT.band_share), REPORT.most_lines)
    first = max(peak - reach, min(peak - REPORT.fewest_lines, int(lower[-1]) - 2 if lower.size else 0), 1)
    last = min(
        peak + reach, max(peak + REPORT.fewest_lines, int(upper[0]) + 2 if upper.size else len(smooth))
    )
    return channel, np.arange(first, min(last + 1, len(smooth)))


def enlarged(curves: DiagnosisCurves, *, added: bool) -> str:
    """Return the section of one FRF with the largest difference of the initial prediction, line by line.

    A difference too small for an axis in decibels is shown as a ratio instead.
    """
    location = largest_difference(curves)
    if location is None:
        return ""
    i, lines = location
    frfs = curves.by_frf
    log_ratio = np.log(frfs.measured[lines, i] / frfs.before[lines, i])
    if np.abs(log_ratio).max() < REPORT.visible_log_ratio:
        return ratio_drawing(frfs, i, added=added)
    section, name = frfs.at_lines(lines), frfs.name(i)
    frequency_axis = svg.frequencies(section.freq)
    valid = _valid(section)[:, i]
    pictures = []
    for quantity in (_magnitude(section, i, valid), _phase(section, i, valid)):
        frame = replace(quantity.frame, x=frequency_axis, height=230.0)
        marks = [svg.line(frame, section.freq, quantity.unbroken(quantity.before), "before")]
        marks += [svg.line(frame, section.freq, quantity.unbroken(quantity.after), "after")] if added else []
        marks += [
            svg.spans(frame, section.freq, quantity.low, quantity.high, "bar"),
            svg.dots(frame, section.freq, quantity.measured, "dot"),
        ]
        pictures.append(f"<figure>{svg.chart(frame, f'{quantity.name} of {name}, enlarged', marks)}</figure>")
    role = "held out of every fit" if frfs.held_out[i] else "fitted"
    caption = (
        f"Response {name}, {role}, near the largest difference of the initial prediction. Dots: measured "
        "lines; bars: ± 2 random errors."
    )
    return (
        f'<h2>Largest difference</h2><p class="soft">{legend(added)}</p>'
        f'<div class="two">{"".join(pictures)}</div><p class="soft">{escape(caption)}</p>'
    )


class _Quantity:
    """Magnitude or phase of one FRF, with its band of random error."""

    def __init__(
        self,
        name: str,
        curves: tuple[FloatArray, FloatArray, FloatArray],
        error: tuple[FloatArray, FloatArray],
        known: BoolArray,
    ) -> None:
        self.name = name
        self.measured, self.before, self.after = curves
        self.low, self.high = (self.measured + offset for offset in error)
        self.frame = svg.Frame(svg.linear(0.0, 1.0, ""), _axis_of(name, curves, known))

    def unbroken(self, curve: FloatArray) -> FloatArray:
        """Return a curve with nan where a phase jumps by a turn, so that no line is drawn there."""
        if self.name != "phase":
            return curve
        broken = curve.copy()
        broken[_turns(curve)] = np.nan
        return broken


def _known(curves: FrfCurves) -> BoolArray:
    # Where the source has no power a measured FRF is noise, and a predicted one 0.
    return np.asarray(curves.random_error < REPORT.largest_known_error)


def _axis_of(name: str, curves: Sequence[FloatArray], known: BoolArray) -> svg.Axis:
    """Return the axis of phases, or that of magnitudes at the lines at which they are known."""
    if name == "phase":
        start = _phase_start(curves[0])
        quarters = tuple((start + 90.0 * i, f"{start + 90 * i:.0f}") for i in range(5))
        return svg.Axis(start - 10.0, start + 370.0, quarters, "phase, degrees")
    levels = np.concatenate([curve[known] for curve in curves])
    levels = levels[np.isfinite(levels)] if np.isfinite(levels).any() else np.zeros(1)
    low, high = np.floor(levels.min() / 5) * 5, np.ceil((levels.max() + 0.1) / 5) * 5
    return svg.linear(low, high, "dB re 1 m/(s² N)", n_ticks=5)


def _magnitude(curves: FrfCurves, i: int, valid: BoolArray) -> _Quantity:
    error = np.minimum(2 * curves.random_error[:, i], DRAWING.largest_error)
    levels = [_decibel(values[:, i], valid) for values in (curves.measured, curves.before, curves.after)]
    return _Quantity(
        "magnitude",
        (levels[0], levels[1], levels[2]),
        (20 * np.log10(1 - error), 20 * np.log10(1 + error)),
        _known(curves)[:, i],
    )


def _phase(curves: FrfCurves, i: int, valid: BoolArray) -> _Quantity:
    error = np.degrees(2 * curves.random_error[:, i])
    phases = [
        np.where(valid, np.degrees(np.angle(values[:, i])), np.nan)
        for values in (curves.measured, curves.before, curves.after)
    ]
    start = _phase_start(phases[0])
    phases = [(phase - start) % 360 + start for phase in phases]
    return _Quantity("phase", (phases[0], phases[1], phases[2]), (-error, error), _known(curves)[:, i])


def _channel(curves: FrfCurves, i: int, reason: str, added: bool) -> str:
    valid = _valid(curves)[:, i]
    name = curves.name(i)
    pictures = []
    for quantity, height in ((_magnitude(curves, i, valid), 190.0), (_phase(curves, i, valid), 110.0)):
        unlabelled = svg.linear(float(curves.freq[0]), float(curves.freq[-1]), "")
        frame = replace(
            quantity.frame, x=unlabelled, height=height
        )  # the residual chart below has the frequency labels
        bundle = [quantity.measured, quantity.before, quantity.after, quantity.low, quantity.high]
        x, (measured, initial, final, low, high) = svg.thinned(curves.freq, bundle, DRAWING.curve_points)
        measured, initial, final = map(quantity.unbroken, (measured, initial, final))
        marks = [
            svg.area(frame, x, low, high, "noise") if quantity.name == "magnitude" else "",
            svg.line(frame, x, initial, "before"),
            svg.line(frame, x, measured, "measured"),
            svg.line(frame, x, final, "after") if added else "",
        ]
        pictures.append(svg.chart(frame, f"{quantity.name} of {name}", marks))
    caption = f"Response {name}, {reason}: magnitude, phase, and residual in random errors."
    pictures.append(_errors(curves, i, valid, name, added))
    return f"<figure>{''.join(pictures)}<figcaption>{escape(caption)}</figcaption></figure>"


def _phase_start(phase: FloatArray) -> float:
    """Return the start, degrees, of the turn in which a measured phase jumps least: -180 or -90.

    Noise about 180 degrees would otherwise cross the whole chart at every other line.
    """
    return min((-180.0, -90.0), key=lambda start: len(_turns((phase - start) % 360)))


def _turns(phase: FloatArray) -> IntArray:
    """Return the indices of the lines before a jump by more than half a turn."""
    return np.flatnonzero(np.abs(np.diff(phase)) > 180)


def _errors(curves: FrfCurves, i: int, valid: BoolArray, name: str, added: bool) -> str:
    initial, final = (
        np.where(valid, residual(curves, predicted)[:, i], np.nan)
        for predicted in (curves.before, curves.after)
    )
    return residual_chart(curves.freq, initial, final, f"residual of {name} in random errors", added)


def _unmeasured(curves: DiagnosisCurves, i: int) -> str:
    assert curves.predicted is not None
    values = curves.predicted[:, i, 0]
    predicted = _decibel(values, (np.abs(values) > 0) & (curves.freq > 0))
    x, (levels,) = svg.thinned(curves.freq, [predicted], DRAWING.curve_points)
    known = np.asarray(_known(curves.by_frf).any(axis=1))
    frame = svg.Frame(svg.frequencies(curves.freq), _axis_of("magnitude", (predicted,), known))
    name = f"{curves.predicted_outputs[i]} / {curves.inputs[0]}"
    chart = svg.chart(frame, f"magnitude of {name}, predicted", [svg.line(frame, x, levels, "after")])
    caption = f"Response {name}, not measured: prediction."
    return f"<figure>{chart}<figcaption>{escape(caption)}</figcaption></figure>"


def _decibel(values: ComplexArray, valid: BoolArray) -> FloatArray:
    return np.asarray(20 * np.log10(np.where(valid, np.abs(values), np.nan)))
