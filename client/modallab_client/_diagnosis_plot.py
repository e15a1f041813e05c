"""The parts of a diagnosis's picture, each on axes that it is given."""

from typing import TYPE_CHECKING, Any

import numpy as np

from modallab_client.methods.diagnoses import place
from modallab_client.models import ComplexArray, FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from modallab_client.results import Diagnosis, DiagnosisCurves, Step

LEVELS = (0.0, 2.0, 5.0, 15.0, 50.0, 1e9)  # random errors at which the colour changes
COLOURS = ("#eef0f4", "#fee3a8", "#fdb158", "#e4572e", "#7a1022")
SEEN = 3.0  # random errors beyond which a difference is worth an enlargement
NEAR = 0.15  # of the largest difference, up to which an enlargement reaches
FEWEST, MOST = 10, 60  # lines on each side of the largest difference
SLIGHT = 0.3  # |ln(measured / predicted)| that curves of an FRF do not show
SURE = 3.0  # typical random errors beyond which a line is left out of a ratio
LEAST_GAP = 0.1  # where the axis of gaps begins
DOTS: dict[str, Any] = {
    "fmt": "k.",
    "markersize": 4,
    "linewidth": 1,
    "zorder": 3,
    "label": "measured, ± 2 random errors",
}
STYLES = {"before": ("C1-", "predicted as given"), "after": ("C0--", "with what was added")}


def heading(found: "Diagnosis") -> str:
    """Return verdict and what was added."""
    lines = [found.verdict.replace("_", " "), *(str(step.effect) for step in found.steps)]
    return "\n".join(lines)


def gap_by_step(axes: "Axes", found: "Diagnosis") -> None:
    """Draw a bar for the FRFs that were fitted and one for those held out, from step to step."""
    steps = found.steps
    names = ["as given", *(f"+ {_two_lines(step)}" for step in steps)]
    gaps: dict[str, list[Any]] = {"all FRFs": [found.remaining_gap]}
    if steps:
        gaps = {"FRFs that were fitted": [steps[0].gap_before, *(step.gap_after for step in steps)]}
        if steps[0].held_out_gap_before is not None:
            held_out = [steps[0].held_out_gap_before, *(step.held_out_gap_after for step in steps)]
            gaps["FRFs held out of every fit"] = held_out
    thick = 0.8 / len(gaps)
    for i, ((label, values), colour) in enumerate(zip(gaps.items(), ("C0", "0.7"), strict=False)):
        lengths = [max(value or 0.0, LEAST_GAP) - LEAST_GAP for value in values]
        places = [row + (i - (len(gaps) - 1) / 2) * thick for row in range(len(values))]
        bars = axes.barh(places, lengths, left=LEAST_GAP, height=0.9 * thick, color=colour, label=label)
        axes.bar_label(bars, [_plain(value) for value in values], padding=3)
    highest = max(value or 1.0 for values in gaps.values() for value in values)
    axes.set(
        xscale="log", xlim=(LEAST_GAP, max(10.0, 20 * highest)), xlabel="gap (1: only random error left)"
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


def residual(curves: "DiagnosisCurves", predicted: ComplexArray) -> FloatArray:
    """Return |ln(measured / predicted)| (n_freq, n_out) in random errors; 0 where there is no logarithm."""
    measured, other = curves.measured[:, :, 0], predicted[:, :, 0]
    good = (np.abs(measured) > 0) & (np.abs(other) > 0) & (curves.freq > 0)[:, None]
    ratio = np.log(np.where(good, measured, 1.0) / np.where(good, other, 1.0))
    return np.asarray(np.abs(ratio) / (np.sqrt(2) * curves.random_error[:, :, 0]))


def where(axes: "Axes", curves: "DiagnosisCurves") -> None:
    """Draw how far the prediction as given is off, by response and frequency."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    off = residual(curves, curves.before)
    colours = ListedColormap(COLOURS)
    image = axes.pcolormesh(
        curves.freq,
        np.arange(len(curves.outputs)),
        off.T,
        cmap=colours,
        norm=BoundaryNorm(LEVELS, len(COLOURS)),
        shading="nearest",
        rasterized=True,
    )
    assert axes.figure is not None
    bar = axes.figure.colorbar(image, ax=axes, spacing="uniform", ticks=LEVELS[1:-1])
    bar.set_label("random errors")
    every = -(-len(curves.outputs) // 20)
    names = [
        f"{name} *" if held else name for name, held in zip(curves.outputs, curves.held_out, strict=True)
    ]
    axes.set_yticks(range(0, len(names), every), names[::every])
    axes.invert_yaxis()
    axes.set(xlabel="frequency, Hz", title="prediction as given (*: held out of every fit)")


def clearest(curves: "DiagnosisCurves") -> "tuple[int, NDArray[np.int64]]":
    """Return the response and the lines where the prediction as given is clearly off; else all lines.

    A response that took no part in the fits is preferred: there the prediction is put to the test.
    """
    off = residual(curves, curves.before)
    held = curves.held_out & (off.max(axis=0) > 2 * SEEN)
    group = np.flatnonzero(held if held.any() else np.ones_like(held))
    output = int(group[off[:, group].max(axis=0).argmax()])
    line = np.convolve(off[:, output], np.ones(3) / 3, mode="same")
    peak = int(line.argmax())
    if line[peak] < SEEN:
        return output, np.arange(1 if curves.freq[0] == 0 else 0, len(line))
    far = np.flatnonzero(line < max(NEAR * line[peak], SEEN))
    below, above = far[far < peak], far[far > peak]
    most = min(max(FEWEST, len(line) // 8), MOST)
    first = max(peak - most, min(peak - FEWEST, int(below[-1]) - 2 if below.size else 0), 1)
    last = min(peak + most, max(peak + FEWEST, int(above[0]) + 2 if above.size else len(line)))
    return output, np.arange(first, min(last + 1, len(line)))


def enlarged(size: "Axes", turn: "Axes", curves: "DiagnosisCurves", *, added: bool) -> None:
    """Draw magnitude and phase of one response where the prediction as given is clearly off.

    A difference that such curves do not show is drawn as a ratio instead, over all lines.
    """
    i, lines = clearest(curves)
    held = ", held out of every fit" if curves.held_out[i] else ""
    size.set_title(f"response {curves.outputs[i]} / {curves.inputs[0]}{held}")
    off = residual(curves, curves.before)[lines, i]
    apart = np.log(np.abs(curves.measured[lines, i, 0] / curves.before[lines, i, 0]))
    turned = np.angle(curves.measured[lines, i, 0] / curves.before[lines, i, 0])
    if off.max() > SEEN and np.hypot(apart, turned).max() < SLIGHT:
        _ratio(size, turn, curves, i, added=added)
    else:
        _curves(size, turn, curves, i, lines, added=added)
    for axes in (size, turn):
        axes.set_xlabel("frequency, Hz")
    size.legend(fontsize="small")


def _styles(added: bool) -> list[tuple[str, str, str]]:
    return [(name, *STYLES[name]) for name in (("before", "after") if added else ("before",))]


def _curves(
    size: "Axes",
    turn: "Axes",
    curves: "DiagnosisCurves",
    i: int,
    lines: "NDArray[np.int64]",
    *,
    added: bool,
) -> None:
    freq, error = curves.freq[lines], curves.random_error[lines, i, 0]
    for name, style, label in _styles(added):
        values = getattr(curves, name)[lines, i, 0]
        size.plot(freq, np.abs(values), style, label=label)
        turn.plot(freq, _unjumped(np.degrees(np.angle(values))), style, label=label)
    measured = curves.measured[lines, i, 0]
    size.errorbar(freq, np.abs(measured), yerr=np.minimum(2 * error, 0.9) * np.abs(measured), **DOTS)
    turn.errorbar(freq, np.degrees(np.angle(measured)), yerr=np.degrees(2 * error), **DOTS)
    size.set(yscale="log", ylabel="|inertance|, m/(s² N)")
    turn.set(ylabel="phase, degrees", ylim=(-190, 190), yticks=range(-180, 181, 90), title="the same: phase")


def _ratio(size: "Axes", turn: "Axes", curves: "DiagnosisCurves", i: int, *, added: bool) -> None:
    error = curves.random_error[:, i, 0]
    sizes = np.minimum(np.abs(curves.measured[:, i, 0]), np.abs(curves.before[:, i, 0]))
    good = np.flatnonzero((curves.freq > 0) & (sizes > 0))
    good = good[error[good] <= SURE * np.median(error[good])]  # others would hide all with their bars
    freq, before = curves.freq[good], curves.before[good, i, 0]
    for name, style, label in _styles(added):
        ratio = getattr(curves, name)[good, i, 0] / before
        size.plot(freq, 100 * (np.abs(ratio) - 1), style, label=label, zorder=4)
        turn.plot(freq, np.degrees(np.angle(ratio)), style, label=label, zorder=4)
    ratio = curves.measured[good, i, 0] / before
    dots = {**DOTS, "ecolor": "0.7"}
    size.errorbar(freq, 100 * (np.abs(ratio) - 1), yerr=200 * error[good], **dots)
    turn.errorbar(freq, np.degrees(np.angle(ratio)), yerr=np.degrees(2 * error[good]), **dots)
    size.set_ylabel("magnitude against the prediction, %")
    turn.set(ylabel="phase against the prediction, degrees", title="the same: phase")


def _unjumped(phase: FloatArray) -> FloatArray:
    """Return a phase without the lines that a jump from -180 to 180 degrees would draw."""
    return np.asarray(np.where(np.abs(np.diff(phase, append=phase[-1:])) > 180, np.nan, phase))
