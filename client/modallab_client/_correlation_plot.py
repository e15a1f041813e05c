"""What a correlation tells, drawn on axes that are there."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from modallab_client.models import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client.results import Correlation, ResponseCorrelation

FEW = 16  # bars that still have room for their names side by side
SMALL = 12  # modes up to which every value of a matrix is written into it


def matrix(axes: "Axes", values: FloatArray) -> Any:
    """Draw values of 0 to 1 by pair of modes, counted from 1; return the image."""
    rows, columns = values.shape
    span = (0.5, columns + 0.5, rows + 0.5, 0.5)
    image = axes.imshow(values, vmin=0, vmax=1, cmap="Blues", extent=span)
    axes.set_xticks(_counted(columns))
    axes.set_yticks(_counted(rows))
    if max(rows, columns) <= SMALL:
        for (i, j), value in np.ndenumerate(values):
            if value >= 0.005:
                colour = "white" if value > 0.6 else "black"
                axes.text(j + 1, i + 1, _brief(value), ha="center", va="center", color=colour, fontsize=7)
    return image


def _brief(value: float) -> str:
    return "1" if value > 0.9995 else f"{value:.3f}"[1:] if value > 0.995 else f"{value:.2f}"[1:]


def _counted(n: int) -> list[int]:
    return list(range(1, n + 1, 1 if n <= 2 * SMALL else 5))


def coordinates(upper: "Axes", lower: "Axes", found: "Correlation") -> None:
    """Draw CoMAC and ECoMAC by DoF."""
    places = np.arange(len(found.comac))
    upper.bar(places, found.comac, color="C0")
    upper.set(ylim=(0, 1.05), ylabel="CoMAC (1 agrees)")
    enhanced = np.zeros(len(places)) if found.ecomac is None else found.ecomac
    lower.bar(places, enhanced, color="C3")
    lower.set_ylabel("ECoMAC (0 agrees)")
    lower.set_ylim(0, max(0.05, 1.1 * float(enhanced.max(initial=0.0))))
    _named(lower, found.dofs or [str(i + 1) for i in places])


def _named(axes: "Axes", names: Sequence[str]) -> None:
    every = 1 + (len(names) - 1) // 40
    axes.set_xticks(range(0, len(names), every))
    turn = 0 if len(names) <= FEW else 90
    axes.set_xticklabels(names[::every], rotation=turn, fontsize="small")


def fdac(axes: "Axes", found: "ResponseCorrelation", drive: str) -> Any:
    """Draw the FDAC of one input with equal frequencies and its ridge; return the mesh."""
    freq, values = found.freq, found.fdac[found.inputs.index(drive)]
    mesh = axes.pcolormesh(
        freq, freq, values, vmin=0, vmax=1, cmap="Blues", shading="nearest", rasterized=True
    )
    axes.plot(freq, freq, color="grey", linewidth=0.8, linestyle="--", label="equal frequencies")
    if found.frequency_scale is not None:
        label = f"ridge: measured = {found.frequency_scale:.3f} model"
        axes.plot(freq, found.frequency_scale * freq, color="C3", linewidth=0.9, label=label)
    axes.set(xlabel="frequency of the model, Hz", ylabel="measured frequency, Hz", title=f"input {drive}")
    axes.set(xlim=(freq[0], freq[-1]), ylim=(freq[0], freq[-1]), aspect="equal")
    axes.legend(fontsize="small", loc="upper left")
    return mesh


def frac(axes: "Axes", found: "ResponseCorrelation") -> None:
    """Draw the FRAC of every FRF: bars by response, one colour an input."""
    n_in = len(found.inputs)
    width = 0.8 / n_in
    places = np.arange(len(found.outputs))
    for i, drive in enumerate(found.inputs):
        axes.bar(places + (i - (n_in - 1) / 2) * width, found.frac[:, i], width=width, label=f"input {drive}")
    _named(axes, found.outputs)
    axes.set(ylim=(0, 1.05), ylabel="FRAC", xlabel="response")
    axes.legend(fontsize="small")
