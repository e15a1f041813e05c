"""An unknown effect in words, and its curve as a drawing."""

from html import escape

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.reporting import svg
from modallab.diagnosis.reporting.page import paragraph
from modallab.diagnosis.reporting.text import gap_text, number_text, place_name
from modallab.diagnosis.result import CurveModelName, Unknown, UnknownCause, UnknownRival
from modallab.diagnosis.unknown.adoption import model_values

MODELS = {
    CurveModelName.SPRING: "that of a spring",
    CurveModelName.MASS: "that of a mass",
    CurveModelName.DAMPER: "that of a viscous damper",
    CurveModelName.HYSTERETIC_SPRING: "that of a spring with a loss factor",
    CurveModelName.SPRING_AND_DAMPER: "that of a spring and a viscous damper in parallel",
    CurveModelName.POWER: "a power of i omega",
    CurveModelName.OSCILLATOR: "that of a mass on a spring with a loss factor",
    CurveModelName.TWO_OSCILLATORS: "that of two masses, each on a spring with a loss factor",
    CurveModelName.DELAYED_DISPLACEMENT_FEEDBACK: "a delayed feedback of displacement",
    CurveModelName.DELAYED_VELOCITY_FEEDBACK: "a delayed feedback of velocity",
    CurveModelName.DELAYED_ACCELERATION_FEEDBACK: "a delayed feedback of acceleration",
    CurveModelName.GAIN: "a constant",
    CurveModelName.FIRST_ORDER_HIGH_PASS: "that of a first-order high-pass filter",
    CurveModelName.FIRST_ORDER_LOW_PASS: "that of a first-order low-pass filter",
    CurveModelName.DELAY: "that of a delay",
}
N_DRAWN = 800  # points of a model's line
METHOD = (
    "No effect of the catalogue accounts for what is left. The force, or the gain, that would account for it "
    "was solved for at every line and at every possible place, together with the parameters within "
    "tolerances; the place is the one at which a single unknown leaves least."
)


def unknown_name(unknown: Unknown | UnknownRival) -> str:
    """Return what an unknown effect acts as, and where."""
    if unknown.cause is UnknownCause.INTERNAL_FORCE:
        return f"an unknown force at {place_name(unknown.at)}"
    if unknown.cause is UnknownCause.CHANNEL_GAIN:
        return f"an unknown gain of {place_name(unknown.at)}"
    return "an unknown gain of all channels, or force at the drive point"


def unknown_text(unknown: Unknown) -> str:
    """Return place, model and gap of an unknown effect in a few sentences."""
    beside = "Beside the added effects, " if unknown.beside_steps else ""
    name = unknown_name(unknown)
    words = [
        f"{beside}{name if beside else name[:1].upper() + name[1:]} closes the gap of the fitted FRFs from "
        f"{gap_text(unknown.gap_before)} to {gap_text(unknown.gap_after)}"
        + (
            f"; of the held-out FRFs from {gap_text(unknown.held_out_gap_before)} to "
            f"{gap_text(unknown.held_out_gap_after)}."
            if np.isfinite(unknown.held_out_gap_after)
            else "."
        )
    ]
    if unknown.curve_model is not None:
        values = ", ".join(
            f"{name.replace('_', ' ')} {number_text(value)}" for name, value in unknown.parameters.items()
        )
        source = f" of {unknown.source}" if unknown.source not in (None, unknown.at) else ""
        words.append(f"Its model is {MODELS[unknown.curve_model]}{source}: {values}.")
    else:
        words.append("Its curve follows none of the models that were tried.")
    if unknown.rivals_alike:
        others = " or ".join(unknown_name(rival) for rival in unknown.rivals_alike)
        words.append(f"This measurement cannot distinguish it from {others}.")
    return " ".join(words)


def unknown_section(unknown: Unknown | None) -> str:
    """Return the section of a report on an unknown effect; empty without one."""
    if unknown is None:
        return ""
    curve = (
        "Dynamic stiffness" if unknown.cause is UnknownCause.INTERNAL_FORCE else "Gain, true over declared"
    )
    scale, prefix = (1.0, "") if unknown.unit == "1" else _prefix(unknown)
    unit = "" if unknown.unit == "1" else f", {prefix}{unknown.unit}"
    modelled = model_values(unknown, _frequencies(unknown)) is not None
    drawings = "".join(
        f"<figure>{_chart(unknown, part, scale, f'{part} part{unit}')}</figure>" for part in ("real", "imag")
    )
    caption = (
        f"{curve} over frequency. Dots: solved for at the lines around each, with two standard errors; "
        f"line: {'the model' if modelled else 'between the dots'}."
    )
    return (
        f"<h2>Effect outside the catalogue</h2>{paragraph(unknown_text(unknown))}"
        f'{paragraph(METHOD, "soft")}<div class="two">{drawings}</div>{paragraph(caption, "soft")}'
    )


def _prefix(unknown: Unknown) -> tuple[float, str]:
    """Return the power of 1000 nearest below the largest value of a curve, with its SI prefix."""
    largest = max(np.hypot(point.real, point.imaginary) for point in unknown.curve)
    power = int(np.clip(np.floor(np.log10(max(largest, np.finfo(float).tiny)) / 3), -2, 3))
    return 1000.0**power, {-2: "µ", -1: "m", 0: "", 1: "k", 2: "M", 3: "G"}[power]


def _frequencies(unknown: Unknown) -> FloatArray:
    """Return frequencies (n,), Hz, near enough to draw a model's resonances."""
    return np.linspace(unknown.curve[0].frequency, unknown.curve[-1].frequency, N_DRAWN)


def _chart(unknown: Unknown, part: str, scale: float, title: str) -> str:
    """Return one part of the curve over a scale, with its model and bars of two standard errors."""
    freq = np.array([point.frequency for point in unknown.curve])
    values = np.array([complex(point.real, point.imaginary) for point in unknown.curve])
    error = np.array([2 * point.standard_error for point in unknown.curve]) / scale
    fine = _frequencies(unknown)
    model = model_values(unknown, fine)
    if model is None:
        fine, model = freq, values
    dots, line = (getattr(each, part) / scale for each in (values, model))
    low = min((dots - error).min(), line.min())
    high = max((dots + error).max(), line.max())
    margin = 0.05 * (high - low) or 1.0
    vertical = svg.linear(low - margin, high + margin, title.replace("imag ", "imaginary "), n_ticks=5)
    frame = svg.Frame(svg.frequencies(freq), vertical, height=260.0)
    marks = [
        svg.spans(frame, freq, dots - error, dots + error, "haze"),
        svg.line(frame, fine, line, "after"),
        svg.dots(frame, freq, dots, "dot"),
    ]
    return svg.chart(frame, escape(title), marks)
