"""Plots of fits, mode indicator functions and stabilisation diagrams on given axes."""

import re
from collections.abc import Callable, Mapping, Sequence
from itertools import cycle
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from modallab_client.models import ComplexArray, FloatArray
from modallab_client.settings import PLOT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from modallab_client.models import Frf
    from modallab_client.results import FitPlotData, Indicators, Measurement, StabilisationChart

RAW, FITTED, DOUBTFUL = "0.65", "C3", "0.35"
DOUBT_MARKS = "xv^s*d"
NUMBERS = re.compile(r"\d[\d.]*")
PARTS = (("real part", np.real, "C0", "o"), ("imaginary part", np.imag, "C1", "s"))
# by stability: label, colour, marker, size
SYMBOLS = (
    ("new", "0.8", ".", 8),
    ("steady in frequency", "C0", ".", 14),
    ("and in damping", "C1", "o", 12),
    ("and in vector", "C2", "o", 16),
)


def heading(plot_data: "FitPlotData") -> str:
    """Return the title of a fit: mode, response, method, and the estimates."""
    quality = "".join(
        f", {name.replace('_', ' ')} {value:.2g} %" for name, value in plot_data.quality.items()
    )
    return (
        f"mode {plot_data.mode} at {plot_data.response}, {plot_data.method}: "
        f"{plot_data.frequency:.6g} Hz, loss factor {plot_data.loss_factor:.4g}{quality}"
    )


def magnitude(axes: "Axes", plot_data: "FitPlotData", unit: str) -> None:
    """Draw |H| of the lines as measured and cleaned, and of the fit."""
    used = plot_data.used
    axes.plot(plot_data.freq, np.abs(plot_data.measured), "x", color=RAW, label="measured")
    axes.plot(
        plot_data.freq[used], np.abs(plot_data.cleaned)[used], "ko", markersize=4, label="freed of others"
    )
    if not used.all():
        axes.plot(
            plot_data.freq[~used],
            np.abs(plot_data.cleaned)[~used],
            "ko",
            markersize=4,
            fillstyle="none",
            label="left out",
        )
    axes.plot(plot_data.curve_freq, np.abs(plot_data.curve), color=FITTED, label="mode and residual")
    axes.set(xlabel="frequency, Hz", ylabel=f"|{plot_data.kind}|, {unit}")
    axes.legend(fontsize="x-small")


def nyquist(axes: "Axes", plot_data: "FitPlotData", unit: str) -> None:
    """Draw the lines and the fit in the complex plane; of a circle-fit the whole circle."""
    z, used = plot_data.cleaned, plot_data.used
    circle = plot_data.details.get("circle")
    if circle is not None:
        axes.plot(circle.real, circle.imag, color=FITTED, linewidth=0.9, label="fitted circle")
        for name, marker in (("centre", "+"), ("resonance", "D")):
            at = np.ravel(plot_data.details[name])
            axes.plot(at.real, at.imag, marker, color=FITTED, markersize=6, linestyle="none", label=name)
    axes.plot(
        plot_data.curve.real, plot_data.curve.imag, color=FITTED, linewidth=1.8 if circle is None else 2.4
    )
    axes.plot(z.real[used], z.imag[used], "ko", markersize=4)
    if not used.all():
        axes.plot(z.real[~used], z.imag[~used], "ko", markersize=4, fillstyle="none")
    axes.set(xlabel=f"real part, {unit}", ylabel="imaginary part")
    axes.set_aspect("equal", adjustable="datalim")
    if circle is not None:
        axes.legend(fontsize="x-small")


def method_plot(figure: "Figure", place: Any, plot_data: "FitPlotData") -> "tuple[Axes, ...]":
    """Draw the plot particular to the method, if it has one; return its axes."""
    draw = METHOD_PLOTS.get(plot_data.method)
    return () if draw is None or not plot_data.details else draw(figure, place, plot_data)


def _damping_surface(figure: "Figure", place: Any, plot_data: "FitPlotData") -> "tuple[Axes, ...]":
    """Draw the loss factor of every pair of lines, one above and one below resonance."""
    axes = figure.add_subplot(place)
    details, loss = plot_data.details, plot_data.loss_factor
    upper, lower = (_hertz(plot_data, np.asarray(details[name])) for name in ("x_above", "x_below"))
    surface = np.asarray(details["damping_surface"])
    if not surface.size:  # all lines to one side
        axes.set_axis_off()
        return (axes,)
    half_range = max(float(np.abs(surface - loss).max()), PLOT.surface_range * loss)
    mesh = axes.pcolormesh(
        lower,
        upper,
        surface,
        vmin=loss - half_range,
        vmax=loss + half_range,
        cmap="coolwarm",
        shading="nearest",
    )
    figure.colorbar(mesh, ax=axes, label="loss factor")
    axes.set(xlabel="line below resonance, Hz", ylabel="line above, Hz")
    axes.set_title("damping by pairs", fontsize="small")
    return (axes,)


def _inverse(figure: "Figure", place: Any, plot_data: "FitPlotData") -> "tuple[Axes, ...]":
    """Draw the inverse of the response and the straight line through it."""
    axes = figure.add_subplot(place)
    _straight(axes, plot_data, plot_data.details["inverse"], plot_data.details["line"])
    axes.set_xlabel(_squared(plot_data))
    axes.set_title("1/(response - residual)", fontsize="small")
    return (axes,)


def _quotients(figure: "Figure", place: Any, plot_data: "FitPlotData") -> "tuple[Axes, ...]":
    """Draw Dobson's difference quotients with their lines, over the slopes of these with theirs."""
    upper, lower = (figure.add_subplot(part) for part in place.subgridspec(2, 1))
    x, delta, lines = (np.asarray(plot_data.details[n]) for n in ("x_delta", "delta", "delta_lines"))
    for row in range(len(x)):
        upper.plot(x[row], delta[row].real, ".", color="C0", markersize=3)
        upper.plot(x[row], lines[row].real, color=FITTED, linewidth=0.5)
    upper.set_title("quotients, real part; a line a reference", fontsize="small")
    _straight(lower, plot_data, plot_data.details["slopes"], plot_data.details["slope_line"])
    lower.set_title("their slopes", fontsize="small")
    lower.set_xlabel(_squared(plot_data))
    return upper, lower


def _sides(figure: "Figure", place: Any, plot_data: "FitPlotData") -> "tuple[Axes, ...]":
    """Draw both sides of the linear fit's equation."""
    axes = figure.add_subplot(place)
    _straight(axes, plot_data, plot_data.details["left"], plot_data.details["right"])
    axes.set_xlabel(_squared(plot_data))
    axes.set_title("response x ω², and its three terms", fontsize="small")
    return (axes,)


def _half_power(figure: "Figure", place: Any, plot_data: "FitPlotData") -> "tuple[Axes, ...]":
    """Draw the peak and the points of half its power."""
    axes = figure.add_subplot(place)
    details = {name: np.ravel(values) for name, values in plot_data.details.items()}
    axes.plot(_hertz(plot_data, details["x"]), details["magnitude"], "ko-", markersize=4, linewidth=0.8)
    axes.plot(_hertz(plot_data, details["x_peak"]), details["peak"], "D", color=FITTED, label="peak")
    axes.plot(_hertz(plot_data, details["x_half"]), details["half"], "s-", color=FITTED, label="half power")
    axes.set_xlabel("frequency, Hz")
    axes.set_title("highest line", fontsize="small")
    axes.legend(fontsize="x-small")
    return (axes,)


METHOD_PLOTS: Mapping[str, Callable[["Figure", Any, "FitPlotData"], "tuple[Axes, ...]"]] = {
    "circle_fit": _damping_surface,
    "line_fit": _inverse,
    "dobson": _quotients,
    "linear_fit": _sides,
    "peak_picking": _half_power,
}


def _straight(axes: "Axes", plot_data: "FitPlotData", points: Any, line: Any) -> None:
    x = plot_data.details["x"]
    for label, part, colour, marker in PARTS:
        axes.plot(x, part(points), marker, color=colour, markersize=4, label=label)
        axes.plot(x, part(line), color=colour, linewidth=0.9)
    axes.legend(fontsize="x-small")


def _hertz(plot_data: "FitPlotData", x: FloatArray) -> FloatArray:
    omega = x if plot_data.damping == "viscous" else np.sqrt(np.maximum(x, 0))
    return np.asarray(omega / (2 * np.pi))


def _squared(plot_data: "FitPlotData") -> str:
    return "ω, rad/s" if plot_data.damping == "viscous" else "ω², (rad/s)²"


def responses(
    upper: "Axes", lower: "Axes", source: "Frf | Measurement", outputs: Sequence[str], *, behind: bool
) -> None:
    """Draw magnitude and phase of some responses to every input."""
    positive = source.freq > 0
    freq = source.freq[positive]
    for output in outputs:
        i = source.outputs.index(output)
        for j, drive in enumerate(source.inputs):
            values = source.values[positive, i, j]
            style: dict[str, Any] = {"color": RAW, "linewidth": 2.0} if behind else {"linewidth": 0.9}
            size = np.where(np.abs(values) > 0, np.abs(values), np.nan)
            label = f"{output} / {drive}"
            if behind:  # one word in the legend for all of them
                label = "_measured" if upper.lines else "measured"
            upper.semilogy(freq, size, label=label, **style)
            lower.plot(freq, _open(values), **style)


def _open(values: ComplexArray) -> FloatArray:
    """Return the phase, degrees, with gaps where it is wrapped."""
    phase = np.degrees(np.angle(values))
    phase[1:][np.abs(np.diff(phase)) > 270] = np.nan
    return np.asarray(phase)


def indicators(upper: "Axes", lower: "Axes", functions: "Indicators") -> None:
    """Draw CMIF and MIF."""
    for n, curve in enumerate(functions.cmif, 1):
        upper.semilogy(functions.freq, np.where(curve > 0, curve, np.nan), linewidth=0.9, label=f"value {n}")
    for drive, curve in zip(functions.inputs, functions.mif, strict=True):
        lower.plot(functions.freq, curve, linewidth=0.9, label=f"force {drive}")
    upper.set_ylabel("CMIF, m/(s N)")
    lower.set(ylim=(0, 1.05), ylabel="MIF (0 at a mode)", xlabel="frequency, Hz")
    for axes in (upper, lower):
        if len(axes.lines) > 1:
            axes.legend(fontsize="x-small")


def chart(axes: "Axes", diagram: "StabilisationChart") -> None:
    """Draw poles by order and frequency, the modes, and the CMIF behind."""
    for frequency in diagram.modes:
        axes.axvline(frequency, color=FITTED, linewidth=0.7, alpha=0.6)
    for level, (label, colour, marker, size) in enumerate(SYMBOLS):
        at_level = diagram.stability == level
        axes.scatter(
            diagram.frequency[at_level],
            diagram.order[at_level],
            s=size,
            c=colour,
            marker=marker,
            label=label,
            linewidths=0,
        )
    selected = np.array([number is not None for number in diagram.mode], dtype=bool)
    axes.scatter(
        diagram.frequency[selected],
        diagram.order[selected],
        s=34,
        facecolors="none",
        edgecolors=FITTED,
        linewidths=0.7,
        label="speaks for a mode",
    )
    _doubtful_poles(axes, diagram)
    axes.set(xlabel="frequency, Hz", ylabel="order")
    if diagram.indicators is not None:
        behind = axes.twinx()
        for curve in diagram.indicators.cmif:
            behind.semilogy(
                diagram.indicators.freq, np.where(curve > 0, curve, np.nan), color="0.6", linewidth=0.8
            )
        behind.set_ylabel("CMIF, m/(s N)", color="0.5")
        axes.set_zorder(behind.get_zorder() + 1)
        axes.patch.set_visible(False)
    # below the axes: inside it would hide poles
    axes.legend(fontsize="x-small", loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=3, frameon=False)


def _doubtful_poles(axes: "Axes", diagram: "StabilisationChart") -> None:
    """Draw poles that are no modes as dotted lines, with a mark for each reason at the top."""
    by_reason: dict[str, list[float]] = {}
    for pole in diagram.doubtful:
        by_reason.setdefault(NUMBERS.sub("…", pole.reason), []).append(pole.frequency)
    for mark, (reason, frequencies) in zip(cycle(DOUBT_MARKS), by_reason.items(), strict=False):
        for frequency in frequencies:
            axes.axvline(frequency, color=DOUBTFUL, linewidth=0.7, linestyle=":", zorder=0)
        axes.plot(
            frequencies,
            np.ones(len(frequencies)),
            mark,
            color=DOUBTFUL,
            markersize=6,
            transform=axes.get_xaxis_transform(),
            clip_on=False,
            label=fill(f"doubtful: {reason}", PLOT.legend_width),
        )
