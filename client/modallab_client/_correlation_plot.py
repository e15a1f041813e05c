"""Plots of a correlation on given axes."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from modallab_client.models import FloatArray
from modallab_client.settings import PLOT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client.results import Correlation, ResponseCorrelation


def matrix(axes: "Axes", values: FloatArray) -> Any:
    """Draw values of 0 to 1 by pair of modes, counted from 1; return the image."""
    rows, columns = values.shape
    span = (0.5, columns + 0.5, rows + 0.5, 0.5)
    image = axes.imshow(values, vmin=0, vmax=1, cmap="Blues", extent=span)
    axes.set_xticks(_mode_ticks(columns))
    axes.set_yticks(_mode_ticks(rows))
    if max(rows, columns) <= PLOT.annotated_modes:
        for (i, j), value in np.ndenumerate(values):
            if value >= PLOT.annotation_floor:
                colour = "white" if value > 0.6 else "black"
                axes.text(j + 1, i + 1, _brief(value), ha="center", va="center", color=colour, fontsize=7)
    return image


def _brief(value: float) -> str:
    return "1" if value > 0.9995 else f"{value:.3f}"[1:] if value > 0.995 else f"{value:.2f}"[1:]


def _mode_ticks(n: int) -> list[int]:
    return list(range(1, n + 1, 1 if n <= 2 * PLOT.annotated_modes else 5))


def coordinates(upper: "Axes", lower: "Axes", correlation: "Correlation") -> None:
    """Draw CoMAC and ECoMAC by DoF."""
    places = np.arange(len(correlation.comac))
    upper.bar(places, correlation.comac, color="C0")
    upper.set(ylim=(0, 1.05), ylabel="CoMAC (1 agrees)")
    enhanced = np.zeros(len(places)) if correlation.ecomac is None else correlation.ecomac
    lower.bar(places, enhanced, color="C3")
    lower.set_ylabel("ECoMAC (0 agrees)")
    lower.set_ylim(0, max(0.05, 1.1 * float(enhanced.max(initial=0.0))))
    _label_names(lower, correlation.dofs or [str(i + 1) for i in places])


def _label_names(axes: "Axes", names: Sequence[str]) -> None:
    step = 1 + (len(names) - 1) // PLOT.labelled_ticks
    axes.set_xticks(range(0, len(names), step))
    rotation = 0 if len(names) <= PLOT.horizontal_labels else 90
    axes.set_xticklabels(names[::step], rotation=rotation, fontsize="small")


def fdac(axes: "Axes", correlation: "ResponseCorrelation", drive: str) -> Any:
    """Draw the FDAC of one input with equal frequencies and its ridge; return the mesh."""
    freq, values = correlation.freq, correlation.fdac[correlation.inputs.index(drive)]
    mesh = axes.pcolormesh(
        freq, freq, values, vmin=0, vmax=1, cmap="Blues", shading="nearest", rasterized=True
    )
    axes.plot(freq, freq, color="grey", linewidth=0.8, linestyle="--", label="equal frequencies")
    if correlation.frequency_scale is not None:
        label = f"ridge: measured = {correlation.frequency_scale:.3f} model"
        axes.plot(freq, correlation.frequency_scale * freq, color="C3", linewidth=0.9, label=label)
    axes.set(xlabel="frequency of the model, Hz", ylabel="measured frequency, Hz", title=f"input {drive}")
    axes.set(xlim=(freq[0], freq[-1]), ylim=(freq[0], freq[-1]), aspect="equal")
    axes.legend(fontsize="small", loc="upper left")
    return mesh


def frac(axes: "Axes", correlation: "ResponseCorrelation") -> None:
    """Draw the FRAC of every FRF: bars by response, one colour an input."""
    n_in = len(correlation.inputs)
    width = 0.8 / n_in
    places = np.arange(len(correlation.outputs))
    for i, drive in enumerate(correlation.inputs):
        axes.bar(
            places + (i - (n_in - 1) / 2) * width, correlation.frac[:, i], width=width, label=f"input {drive}"
        )
    _label_names(axes, correlation.outputs)
    axes.set(ylim=(0, 1.05), ylabel="FRAC", xlabel="response")
    axes.legend(fontsize="small")
