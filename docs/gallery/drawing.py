"""Pictures of effects: before in grey, after in colour."""

import io
from functools import lru_cache
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from PIL import Image

from docs.gallery.curves import LINES, Panel, Picture, picture
from modallab.core.arrays import FloatArray

SIZE, DPI = (6.4, 4.8), 100  # inches: 640 x 480 points
REFERENCE_COLOUR, COLOURS = "#aaaaaa", ("#c23b22", "#1f5fa8")
STYLE: Any = {
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "axes.titlesize": 10,
    "legend.fontsize": 8,
}
UNITS = {
    "magnitude": "|H|, dB",
    "ratio": "change of\n|H|, dB",
    "turn": "change of\nphase, °",
    "phase": "phase, °",
    "coherence": "coherence",
    "force": "force, dB\nre 1 N²/Hz",
    "response": "response, dB\nre 1 (m/s²)²/Hz",
}


def draw(kind: str, n_lines: int = LINES) -> Figure:
    """Return the picture of an effect.

    Parameters
    ----------
    n_lines
        Of the analyser; few make a quick, coarse picture.
    """
    return drawn(picture(kind, n_lines))


def drawn(whole: Picture) -> Figure:
    """Return the figure of curves that are known."""
    with rc_context(STYLE):
        figure = Figure(figsize=SIZE, dpi=DPI, layout="constrained")
        rows = [1.6 if panel.quantity == "magnitude" else 1.0 for panel in whole.panels]
        grid = {"height_ratios": rows}
        axes = figure.subplots(len(rows), 1, sharex=True, squeeze=False, gridspec_kw=grid)[:, 0]
        for axis, panel in zip(axes, whole.panels, strict=True):
            _curves(axis, whole, panel)
        axes[0].set_title(whole.kind, loc="left", fontweight="bold")
        axes[-1].set(xlabel="frequency, Hz", xlim=whole.example.band)
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper right", ncols=len(labels), frameon=False)
    return figure


def _curves(axes: Axes, whole: Picture, panel: Panel) -> None:
    freq, visible_lines = whole.freq[whole.shown], whole.shown
    turning = panel.quantity == "phase"
    reference = panel.of(whole.reference, whole.reference)[visible_lines]
    axes.plot(
        freq,
        _open(reference) if turning else reference,
        color=REFERENCE_COLOUR,
        linewidth=2.4,
        label="without",
    )
    for colour, curve in zip(COLOURS, whole.curves, strict=False):
        values = panel.of(curve.measurement, whole.reference)[visible_lines]
        axes.plot(freq, _open(values) if turning else values, color=colour, linewidth=1.1, label=curve.label)
    axes.set_ylabel(_label(whole, panel))
    if panel.quantity == "coherence":
        axes.set_ylim(min(0.0, *axes.get_ylim()) if axes.get_ylim()[0] < 0.9 else None, 1.02)
    if turning:
        axes.set(ylim=(-190, 190), yticks=(-180, -90, 0, 90, 180))


def _label(whole: Picture, panel: Panel) -> str:
    unit = UNITS[panel.quantity]
    if panel.quantity == "magnitude":
        return f"{unit}\n{panel.output} / {whole.reference.frf.inputs[0]}"
    return (
        unit
        if len({panel_of_figure.output for panel_of_figure in whole.panels}) == 1
        else f"{unit}\n{panel.output}"
    )


def _open(phase: FloatArray) -> FloatArray:
    """Return a phase, degrees, with gaps where it leaps from one end to the other."""
    out = phase.copy()
    out[1:][np.abs(np.diff(phase)) > 270] = np.nan
    return out


def png(figure: Figure) -> bytes:
    """Return a figure as a small picture: 640 x 480 in a palette, without date or program."""
    raw, small = io.BytesIO(), io.BytesIO()
    figure.savefig(raw, format="png", dpi=DPI, metadata={"Software": None})
    image = Image.open(raw).convert("RGB")
    image.quantize(palette=_palette(), dither=Image.Dither.NONE).save(small, format="png", optimize=True)
    return small.getvalue()


@lru_cache(maxsize=1)
def _palette() -> Image.Image:
    """Return what colours there are: black to white, and from every curve's colour to grey and to white."""
    greys = [(level,) * 3 for level in range(0, 256, 17)]
    curves = [to_rgb(colour) for colour in COLOURS]
    backs = [(1.0, 1.0, 1.0), to_rgb(REFERENCE_COLOUR)]
    mixed = [
        tuple(round(255 * (t * c + (1 - t) * b)) for c, b in zip(curve, background, strict=True))
        for curve in curves
        for background in backs
        for t in (0.25, 0.5, 0.75, 1.0)
    ]
    image = Image.new("P", (1, 1))
    image.putpalette([part for colour in (*greys, *mixed) for part in colour])
    return image
