"""Plots of a diagnosis on given axes."""

from typing import TYPE_CHECKING, Any

import numpy as np

from modallab_client.methods.diagnoses import place
from modallab_client.models import ComplexArray, FloatArray
from modallab_client.settings import DIAGNOSIS_PLOT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from modallab_client.methods.diagnoses import FrfCurves
    from modallab_client.results import Diagnosis, Step

COLOURS = ("#eef0f4", "#fee3a8", "#fdb158", "#e4572e", "#7a1022")
DOTS: dict[str, Any] = {
    "fmt": "k.",
    "markersize": 4,
    "linewidth": 1,
    "zorder": 3,
    "label": "measured, ± 2 random errors",
}
STYLES = {"before": ("C1-", "predicted as given"), "after": ("C0--", "with what was added")}


def heading(diagnosis: "Diagnosis") -> str:
    """Return the title: the verdict, and the added effects."""
    lines = [diagnosis.verdict.replace("_", " "), *(str(step.effect) for step in diagnosis.steps)]
    return "\n".join(lines)


def gap_by_step(axes: "Axes", diagnosis: "Diagnosis") -> None:
    """Draw a bar for the FRFs that were fitted and one for those held out, from step to step."""
    steps = diagnosis.steps
    names = ["as given", *(f"+ {_two_lines(step)}" for step in steps)]
    gaps: dict[str, list[Any]] = {"all FRFs": [diagnosis.remaining_gap]}
    if steps:
        gaps = {"FRFs that were fitted": [steps[0].gap_before, *(step.gap_after for step in steps)]}
        if steps[0].held_out_gap_before is not None:
            held_out = [steps[0].held_out_gap_before, *(step.held_out_gap_after for step in steps)]
            gaps["FRFs held out of every fit"] = held_out
    thick = 0.8 / len(gaps)
    for i, ((label, values), colour) in enumerate(zip(gaps.items(), ("C0", "0.7"), strict=False)):
        lengths = [
            max(value or 0.0, DIAGNOSIS_PLOT.smallest_gap) - DIAGNOSIS_PLOT.smallest_gap for value in values
        ]
        places = [row + (i - (len(gaps) - 1) / 2) * thick for row in range(len(values))]
        bars = axes.barh(
            places, lengths, left=DIAGNOSIS_PLOT.smallest_gap, height=0.9 * thick, color=colour, label=label
        )
        axes.bar_label(bars, [_plain(value) for value in values], padding=3)
    highest = max(value or 1.0 for values in gaps.values() for value in values)
    axes.set(
        xscale="log",
        xlim=(DIAGNOSIS_PLOT.smallest_gap, max(10.0, 20 * highest)),
        xlabel="gap (1: only random error left)",
    )
    axes.axvline(1.0, color="0.4", linewidth=0.8, linestyle=":")
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(max(len(names), 2) - 0.5, -0.5)  # downward
    if len(gaps) > 1:
        axes.legend(fontsize="small", loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)


def _two_lines(step: "Step") -> str:
    kind, at = step.effect.kind.replace("_", " "), step.effect.at
    return kind if at is None else f"{kind}\nat {place(at)}"


def _plain(value: float | None) -> str:
    if value is None:
        return ""
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def residual(curves: "FrfCurves", predicted: ComplexArray) -> FloatArray:
    """Return |ln(measured / predicted)| (n_freq, n_frf) in random errors; 0 where there is no logarithm."""
    measured, model = curves.measured, predicted
    good = (np.abs(measured) > 0) & (np.abs(model) > 0) & (curves.freq > 0)[:, None]
    ratio = np.log(np.where(good, measured, 1.0) / np.where(good, model, 1.0))
    return np.asarray(np.abs(ratio) / (np.sqrt(2) * curves.random_error))


def difference_map(axes: "Axes", curves: "FrfCurves") -> None:
    """Draw the difference between measurement and prediction as given, by FRF and frequency."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    difference = residual(curves, curves.before)
    colours = ListedColormap(COLOURS)
    image = axes.pcolormesh(
        curves.freq,
        np.arange(len(curves.outputs)),
        difference.T,
        cmap=colours,
        norm=BoundaryNorm(DIAGNOSIS_PLOT.levels, len(COLOURS)),
        shading="nearest",
        rasterized=True,
    )
    assert axes.figure is not None
    bar = axes.figure.colorbar(image, ax=axes, spacing="uniform", ticks=DIAGNOSIS_PLOT.levels[1:-1])
    bar.set_label("random errors")
    step = -(-len(curves.outputs) // 20)
    names = [
        f"{name} *" if is_held_out else name
        for name, is_held_out in zip(curves.names, curves.held_out, strict=True)
    ]
    axes.set_yticks(range(0, len(names), step), names[::step])
    axes.invert_yaxis()
    axes.set(xlabel="frequency, Hz", title="prediction as given (*: held out of every fit)")


def clearest(curves: "FrfCurves") -> "tuple[int, NDArray[np.int64]]":
    """Return the response and the lines where the prediction as given is clearly off; else all lines.

    A response that took no part in the fits is preferred: there the prediction is put to the test.
    """
    difference = residual(curves, curves.before)
    clear_held_out = curves.held_out & (difference.max(axis=0) > 2 * DIAGNOSIS_PLOT.significant)
    group = np.flatnonzero(clear_held_out if clear_held_out.any() else np.ones_like(clear_held_out))
    output = int(group[difference[:, group].max(axis=0).argmax()])
    line = np.convolve(difference[:, output], np.ones(3) / 3, mode="same")
    peak = int(line.argmax())
    if line[peak] < DIAGNOSIS_PLOT.significant:
        return output, np.arange(1 if curves.freq[0] == 0 else 0, len(line))
    flank_lines = np.flatnonzero(line < max(DIAGNOSIS_PLOT.flank * line[peak], DIAGNOSIS_PLOT.significant))
    lower, upper = flank_lines[flank_lines < peak], flank_lines[flank_lines > peak]
    most = min(max(DIAGNOSIS_PLOT.fewest_lines, len(line) // 8), DIAGNOSIS_PLOT.most_lines)
    first = max(
        peak - most, min(peak - DIAGNOSIS_PLOT.fewest_lines, int(lower[-1]) - 2 if lower.size else 0), 1
    )
    last = min(
        peak + most, max(peak + DIAGNOSIS_PLOT.fewest_lines, int(upper[0]) + 2 if upper.size else len(line))
    )
    return output, np.arange(first, min(last + 1, len(line)))


def enlarged(magnitude_axes: "Axes", phase_axes: "Axes", curves: "FrfCurves", *, added: bool) -> None:
    """Draw magnitude and phase of one response where the prediction as given is clearly off.

    A difference that such curves do not show is drawn as a ratio instead, over all lines.
    """
    i, lines = clearest(curves)
    suffix = ", held out of every fit" if curves.held_out[i] else ""
    magnitude_axes.set_title(f"response {curves.outputs[i]} / {curves.inputs[i]}{suffix}")
    difference = residual(curves, curves.before)[lines, i]
    log_ratio = np.log(np.abs(curves.measured[lines, i] / curves.before[lines, i]))
    phase_difference = np.angle(curves.measured[lines, i] / curves.before[lines, i])
    if (
        difference.max() > DIAGNOSIS_PLOT.significant
        and np.hypot(log_ratio, phase_difference).max() < DIAGNOSIS_PLOT.visible_difference
    ):
        _ratio(magnitude_axes, phase_axes, curves, i, added=added)
    else:
        _curves(magnitude_axes, phase_axes, curves, i, lines, added=added)
    for axes in (magnitude_axes, phase_axes):
        axes.set_xlabel("frequency, Hz")
    phase_axes.legend(fontsize="small")  # in the magnitude it would hide the peak


def _styles(added: bool) -> list[tuple[str, str, str]]:
    return [(name, *STYLES[name]) for name in (("before", "after") if added else ("before",))]


def _curves(
    magnitude_axes: "Axes",
    phase_axes: "Axes",
    curves: "FrfCurves",
    i: int,
    lines: "NDArray[np.int64]",
    *,
    added: bool,
) -> None:
    freq, error = curves.freq[lines], curves.random_error[lines, i]
    for name, style, label in _styles(added):
        values = getattr(curves, name)[lines, i]
        magnitude_axes.plot(freq, np.abs(values), style, label=label)
        phase_axes.plot(freq, _unjumped(np.degrees(np.angle(values))), style, label=label)
    measured = curves.measured[lines, i]
    magnitude_axes.errorbar(
        freq, np.abs(measured), yerr=np.minimum(2 * error, 0.9) * np.abs(measured), **DOTS
    )
    phase_axes.errorbar(freq, np.degrees(np.angle(measured)), yerr=np.degrees(2 * error), **DOTS)
    magnitude_axes.set(yscale="log", ylabel="|inertance|, m/(s² N)")
    phase_axes.set(
        ylabel="phase, degrees", ylim=(-190, 190), yticks=range(-180, 181, 90), title="the same: phase"
    )


def _ratio(magnitude_axes: "Axes", phase_axes: "Axes", curves: "FrfCurves", i: int, *, added: bool) -> None:
    error = curves.random_error[:, i]
    sizes = np.minimum(np.abs(curves.measured[:, i]), np.abs(curves.before[:, i]))
    good = np.flatnonzero((curves.freq > 0) & (sizes > 0))
    good = good[
        error[good] <= DIAGNOSIS_PLOT.largest_error * np.median(error[good])
    ]  # the error bars of others would hide all
    freq, reference = curves.freq[good], curves.before[good, i]
    for name, style, label in _styles(added):
        ratio = getattr(curves, name)[good, i] / reference
        magnitude_axes.plot(freq, 100 * (np.abs(ratio) - 1), style, label=label, zorder=4)
        phase_axes.plot(freq, np.degrees(np.angle(ratio)), style, label=label, zorder=4)
    ratio = curves.measured[good, i] / reference
    dots = {**DOTS, "ecolor": "0.7"}
    magnitude_axes.errorbar(freq, 100 * (np.abs(ratio) - 1), yerr=200 * error[good], **dots)
    phase_axes.errorbar(freq, np.degrees(np.angle(ratio)), yerr=np.degrees(2 * error[good]), **dots)
    magnitude_axes.set_ylabel("magnitude against the prediction, %")
    phase_axes.set(ylabel="phase against the prediction, degrees", title="the same: phase")


def _unjumped(phase: FloatArray) -> FloatArray:
    """Return a phase without the lines that a jump from -180 to 180 degrees would draw."""
    return np.asarray(np.where(np.abs(np.diff(phase, append=phase[-1:])) > 180, np.nan, phase))
