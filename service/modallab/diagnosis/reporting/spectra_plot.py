"""Drawings of auto spectra that the initial prediction does not match."""

from html import escape

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.diagnosis.reporting import svg
from modallab.diagnosis.reporting.legend import legend
from modallab.diagnosis.reporting.residual_plot import residual_chart
from modallab.diagnosis.reporting.settings import DRAWING, REPORT
from modallab.diagnosis.result_curves import DiagnosisCurves, Spectra


def spectra_drawings(curves: DiagnosisCurves, *, added: bool) -> str:
    """Return the force spectrum and the incoherent response spectrum where the initial prediction is off."""
    figures = []
    if curves.force is not None:
        name = "Force spectrum"
        figures.append(_figure(curves, curves.force, "dB re 1 N²/Hz", name, added))
    if curves.incoherent is not None:
        name = "Part of the response not coherent with the force (noise, leakage, nonlinearity)"
        figures.append(_figure(curves, curves.incoherent, "dB re 1 (m/s²)²/Hz", name, added))
    if not any(figures):
        return ""
    return (
        f'<h2>Auto spectra</h2><p class="soft">{legend(added)}</p><div class="two">{"".join(figures)}</div>'
    )


def _residual(spectra: Spectra, predicted: FloatArray, positive: BoolArray) -> FloatArray:
    ratio = np.log(np.where(positive, spectra.measured, 1.0) / np.where(positive, predicted, 1.0))
    return np.asarray(np.abs(ratio) / spectra.random_error)


def _figure(curves: DiagnosisCurves, spectra: Spectra, unit: str, quantity: str, added: bool) -> str:
    """Return level and residual of the worst channel, one above the other; empty if all channels agree."""
    lowest = np.minimum(np.minimum(spectra.measured, spectra.before), spectra.after)
    positive = (curves.freq > 0)[:, None] & (lowest > 0)
    gap = (_residual(spectra, spectra.before, positive) ** 2).mean(axis=0)
    i = int(gap.argmax())
    if gap[i] < REPORT.spectrum_gap:
        return ""
    valid = positive[:, i]
    name = f"{quantity}, {_channel(curves, spectra, i)}"
    levels = [
        np.where(valid, 10 * np.log10(np.where(valid, values[:, i], 1.0)), np.nan)
        for values in (spectra.measured, spectra.before, spectra.after)
    ]
    x, (measured, initial, final) = svg.thinned(curves.freq, levels, DRAWING.curve_points)
    finite = np.concatenate([curve[np.isfinite(curve)] for curve in (measured, initial, final)])
    low, high = np.floor(finite.min() / 5) * 5, np.ceil((finite.max() + 0.1) / 5) * 5
    unlabelled = svg.linear(float(curves.freq[0]), float(curves.freq[-1]), "")
    frame = svg.Frame(unlabelled, svg.linear(low, high, unit, n_ticks=5), height=190.0)
    marks = [
        svg.line(frame, x, measured, "measured"),
        svg.line(frame, x, initial, "before"),
        svg.line(frame, x, final, "after") if added else "",
    ]
    pictures = svg.chart(frame, name, marks) + _difference(curves, spectra, i, positive, name, added)
    return f"<figure>{pictures}<figcaption>{escape(name)}.</figcaption></figure>"


def _difference(
    curves: DiagnosisCurves, spectra: Spectra, i: int, positive: BoolArray, name: str, added: bool
) -> str:
    initial, final = (
        np.where(positive[:, i], _residual(spectra, predicted, positive)[:, i], np.nan)
        for predicted in (spectra.before, spectra.after)
    )
    return residual_chart(curves.freq, initial, final, f"{name}: residual in random errors", added)


def _channel(curves: DiagnosisCurves, spectra: Spectra, i: int) -> str:
    """Return the name of a spectrum's FRF, force or response; a spectrum may be common to a run."""
    frfs, n = curves.by_frf, spectra.measured.shape[1]
    if len(curves.inputs) > 1:
        if n == len(frfs.outputs):
            return frfs.name(i)
        return f"force at {curves.inputs[i]}" if spectra is curves.force else f"response {curves.outputs[i]}"
    return f"response {curves.outputs[i]}" if n == len(curves.outputs) else "common to all responses"
