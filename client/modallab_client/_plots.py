"""Plots of results, the only modules that need matplotlib, imported when a plot is drawn."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from modallab_client.errors import MissingExtraError
from modallab_client.settings import PLOT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client.models import Frf
    from modallab_client.results import (
        Correlation,
        Diagnosis,
        DiagnosisCurves,
        FitPlotData,
        Indicators,
        Measurement,
        ModalModel,
        ResponseCorrelation,
        StabilisationChart,
        Study,
    )

UNITS = {"receptance": "m/N", "mobility": "m/(s N)", "inertance": "m/(s² N)"}


def pyplot() -> Any:
    """Return the module that draws.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    try:
        from matplotlib import pyplot as drawing
    except ImportError as error:
        raise MissingExtraError("drawing needs matplotlib: pip install 'modallab[plot]'") from error
    return drawing


def measurement(test: "Measurement") -> "tuple[Axes, Axes]":
    """Draw |H| of every FRF over the coherence; return both axes."""
    rows = {"height_ratios": [3, 1]}
    _, (upper, lower) = pyplot().subplots(2, 1, sharex=True, gridspec_kw=rows, layout="constrained")
    positive = test.freq > 0  # at rest there is rounding and nothing else
    freq, magnitude = test.freq[positive], np.abs(test.values[positive])
    for i, output in enumerate(test.outputs):
        for j, drive in enumerate(test.inputs):
            # zeros have no logarithm: leave them out of the curve
            curve = np.where(magnitude[:, i, j] > 0, magnitude[:, i, j], np.nan)
            upper.semilogy(freq, curve, label=f"{output} / {drive}", linewidth=0.9)
    upper.set_ylabel(f"|{test.kind}|, {UNITS.get(test.kind, '')}")
    if len(upper.lines) <= PLOT.legend_curves:
        upper.legend(fontsize="x-small", ncols=2)
    if test.coherence is not None:
        lower.plot(freq, test.coherence[positive].reshape(len(freq), -1), linewidth=0.7)
    lower.set(ylim=(0, 1.05), ylabel="coherence", xlabel="frequency, Hz")
    return upper, lower


def modal_model(model: "ModalModel") -> "Axes":
    """Draw loss factor over frequency with standard deviations; return the axes."""
    _, axes = pyplot().subplots(layout="constrained")
    across = [m.frequency_spread.sd if m.frequency_spread else 0.0 for m in model.modes]
    up = [m.loss_factor_spread.sd if m.loss_factor_spread else 0.0 for m in model.modes]
    axes.errorbar(model.frequencies, model.loss_factors, xerr=across, yerr=up, fmt="o", capsize=3)
    for number, (x, y) in enumerate(zip(model.frequencies, model.loss_factors, strict=True), 1):
        axes.annotate(str(number), (x, y), textcoords="offset points", xytext=(5, 5))
    axes.set(xlabel="frequency, Hz", ylabel="loss factor")
    highest = max((y + error for y, error in zip(model.loss_factors, up, strict=True)), default=0.0)
    axes.set_ylim(0, (1 + PLOT.margin) * highest or None)
    return axes  # type: ignore[no-any-return]


def frf(synthesised: "Frf", measured: "Measurement | None", output: str | None) -> "tuple[Axes, Axes]":
    """Draw synthesised FRFs, magnitude over phase, with the measured ones behind; return both axes."""
    from modallab_client import _extraction_plot as parts

    if measured is not None and measured.kind != synthesised.kind:
        raise ValueError(f"these are {synthesised.kind}, the measured ones {measured.kind}: ask for one kind")
    rows = {"height_ratios": [3, 1]}
    _, (upper, lower) = pyplot().subplots(2, 1, sharex=True, gridspec_kw=rows, layout="constrained")
    outputs = synthesised.outputs if output is None else (output,)
    if measured is not None:
        parts.responses(upper, lower, measured, outputs, behind=True)
    parts.responses(upper, lower, synthesised, outputs, behind=False)
    upper.set_ylabel(f"|{synthesised.kind}|, {UNITS.get(synthesised.kind, '')}")
    lower.set(xlabel="frequency, Hz", ylabel="phase, degrees", ylim=(-190, 190), yticks=(-180, 0, 180))
    if len(outputs) <= PLOT.legend_curves:
        upper.legend(fontsize="x-small", ncols=2)
    return upper, lower


def fit(plot_data: "FitPlotData") -> "tuple[Axes, ...]":
    """Draw one fit: magnitude, Nyquist plot, and the plot particular to the method; return the axes."""
    from modallab_client import _extraction_plot as parts

    figure = pyplot().figure(figsize=(11, 4), layout="constrained")
    first, second, third = figure.add_gridspec(1, 3, width_ratios=[1.1, 1, 1.1])
    size, turn = figure.add_subplot(first), figure.add_subplot(second)
    figure.suptitle(parts.heading(plot_data), fontsize="medium")
    parts.magnitude(size, plot_data, UNITS.get(plot_data.kind, ""))
    parts.nyquist(turn, plot_data, UNITS.get(plot_data.kind, ""))
    return size, turn, *parts.method_plot(figure, third, plot_data)


def indicators(functions: "Indicators") -> "tuple[Axes, Axes]":
    """Draw CMIF over MIF; return both axes."""
    from modallab_client import _extraction_plot as parts

    _, (upper, lower) = pyplot().subplots(2, 1, sharex=True, layout="constrained")
    parts.indicators(upper, lower, functions)
    return upper, lower


def chart(diagram: "StabilisationChart") -> "Axes":
    """Draw order over frequency by stability, modes and CMIF; return the axes."""
    from modallab_client import _extraction_plot as parts

    _, axes = pyplot().subplots(figsize=(9, 5), layout="constrained")
    parts.chart(axes, diagram)
    return axes  # type: ignore[no-any-return]


def mac(correlation: "Correlation") -> "Axes":
    """Draw the MAC matrix; return the axes."""
    from modallab_client import _correlation_plot as parts

    figure, axes = pyplot().subplots(layout="constrained")
    figure.colorbar(parts.matrix(axes, correlation.mac), label="MAC")
    axes.set(xlabel="mode of the model", ylabel="measured mode")
    return axes  # type: ignore[no-any-return]


def coordinates(correlation: "Correlation") -> "tuple[Axes, Axes]":
    """Draw CoMAC over ECoMAC by DoF; return both axes."""
    from modallab_client import _correlation_plot as parts

    _, (upper, lower) = pyplot().subplots(2, 1, sharex=True, layout="constrained")
    parts.coordinates(upper, lower, correlation)
    return upper, lower


def orthogonality(correlation: "Correlation") -> "tuple[Axes, Axes]":
    """Draw cross- and auto-orthogonality side by side; return both axes."""
    from modallab_client import _correlation_plot as parts

    orthogonality = correlation.orthogonality
    if orthogonality is None:
        raise ValueError("this correlation was made without a reduction of the mass")
    figure, (cross_axes, auto_axes) = pyplot().subplots(1, 2, figsize=(10, 4.5), layout="constrained")
    image = parts.matrix(cross_axes, orthogonality.cross)
    figure.colorbar(
        image, ax=[cross_axes, auto_axes], label=f"orthogonality in {orthogonality.reduction} mass"
    )
    parts.matrix(auto_axes, orthogonality.auto)
    cross_axes.set(xlabel="mode of the model", ylabel="measured mode", title="cross-orthogonality")
    auto_axes.set(xlabel="measured mode", ylabel="measured mode", title="auto-orthogonality")
    return cross_axes, auto_axes


def fdac(correlation: "ResponseCorrelation", drive: str) -> "Axes":
    """Draw the FDAC of one input; return the axes."""
    from modallab_client import _correlation_plot as parts

    figure, axes = pyplot().subplots(layout="constrained")
    figure.colorbar(parts.fdac(axes, correlation, drive), label="FDAC")
    return axes  # type: ignore[no-any-return]


def frac(correlation: "ResponseCorrelation") -> "Axes":
    """Draw the FRAC of every FRF; return the axes."""
    from modallab_client import _correlation_plot as parts

    _, axes = pyplot().subplots(layout="constrained")
    parts.frac(axes, correlation)
    return axes  # type: ignore[no-any-return]


def dof_errors(errors: Mapping[str, Sequence[float]]) -> "Axes":
    """Draw the errors of each matrix by DoF, in order; return the axes."""
    _, axes = pyplot().subplots(layout="constrained")
    for matrix, values in errors.items():
        axes.semilogy(range(1, len(values) + 1), values, ".", label=matrix)
    axes.set(xlabel="DoF, by error", ylabel="relative error")
    axes.legend()
    return axes  # type: ignore[no-any-return]


def coefficients(
    table: Mapping[str, Mapping[int, float]], standard_errors: Mapping[str, Mapping[int, float | None]]
) -> "Axes":
    """Draw coefficients by part and member with their standard errors; return the axes."""
    _, axes = pyplot().subplots(layout="constrained")
    width = 0.8 / max(1, len(table))
    for i, (part, members) in enumerate(table.items()):
        unchanged = 0.0 if part == "damping" else 1.0
        errors = [standard_errors.get(part, {}).get(member) or 0.0 for member in members]
        places = [member + i * width for member in members]
        changes = [value - unchanged for value in members.values()]
        name = "damping: 1 + loss factor" if part == "damping" else part
        axes.bar(places, changes, width=width, bottom=1, yerr=errors, label=name)
    axes.axhline(1.0, color="grey", linewidth=0.8)
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.margins(y=PLOT.margin)
    axes.use_sticky_edges = False
    axes.set(xlabel="member", ylabel="coefficient (1 = no change)")
    axes.legend()
    return axes  # type: ignore[no-any-return]


def study(results: "Study") -> "tuple[Axes, ...]":
    """Draw errors, suspects and coverage by level of noise; return the axes."""
    from modallab_client import _study_plot as parts

    _, grid = pyplot().subplots(2, 2, figsize=(10, 7), sharex=True, layout="constrained")
    parts.errors(grid[0, 0], results, lambda cell: cell.coefficient_error)
    parts.errors(grid[0, 1], results, lambda cell: cell.frequency_error)
    parts.shares(grid[1, 0], results, lambda cell: cell.suspected)
    parts.shares(grid[1, 1], results, lambda cell: cell.coverage)
    grid[0, 0].set_ylabel("largest error of a coefficient, median to 90 %")
    grid[0, 1].set_ylabel("largest error of a frequency, relative")
    grid[1, 0].set(ylabel="runs that suspect all that is wrong, %", xlabel="level of noise")
    grid[1, 1].set(ylabel="95 % intervals that hold the truth, %", xlabel="level of noise")
    grid[1, 1].axhline(95.0, color="grey", linewidth=0.8)
    grid[0, 0].legend(fontsize="small")
    return tuple(grid.flat)


def diagnosis(result: "Diagnosis") -> "tuple[Axes, ...]":
    """Draw the gap by step, and the measured and predicted curves if there are any; return the axes."""
    from modallab_client import _diagnosis_plot as parts

    drawing = pyplot()
    if result.curves is None:
        _, axes = drawing.subplots(layout="constrained")
        parts.gap_by_step(axes, result)
        axes.set_title(parts.heading(result))
        return (axes,)
    figure, grid = drawing.subplots(2, 2, figsize=(11, 7), layout="constrained")
    figure.suptitle(parts.heading(result))
    parts.gap_by_step(grid[0, 0], result)
    frfs = result.curves.by_frf()
    parts.difference_map(grid[0, 1], frfs)
    parts.enlarged(grid[1, 0], grid[1, 1], frfs, added=bool(result.steps))
    return tuple(grid.flat)


def curves(all_curves: "DiagnosisCurves", output: str, drive: str) -> "Axes":
    """Draw one response of a diagnosis to the force at one drive point; return the axes."""
    _, axes = pyplot().subplots(layout="constrained")
    frfs = all_curves.by_frf()
    i = list(zip(frfs.outputs, frfs.inputs, strict=True)).index((output, drive))
    positive = frfs.freq > 0  # at rest there is rounding and nothing else
    for name, style in (("measured", "k-"), ("before", "C1-"), ("after", "C0--")):
        size = np.abs(getattr(frfs, name)[positive, i])
        axes.semilogy(frfs.freq[positive], size, style, label=name, linewidth=0.9)
    suffix = ", held out of every fit" if frfs.held_out[i] else ""
    axes.set(xlabel="frequency, Hz", ylabel="|inertance|, m/(s² N)")
    axes.set_title(f"response {output} / {drive}{suffix}")
    axes.legend()
    return axes  # type: ignore[no-any-return]
