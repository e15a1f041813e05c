"""The auto spectra of a report, where they tell what the FRFs do not."""

from html import escape

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.diagnosis.reporting import svg
from modallab.diagnosis.reporting.legend import legend
from modallab.diagnosis.reporting.residual_plot import POINTS, differences
from modallab.diagnosis.result_curves import Curves, Spectra

TELLING = 1.5  # mean squared residual above which a spectrum is drawn


def spectra_drawn(curves: Curves, *, added: bool) -> str:
    """Return the force spectrum, and what is not coherent with it, where the prediction as given is off."""
    figures = []
    if curves.force is not None:
        words = "The spectrum of the force"
        figures.append(_figure(curves, curves.force, "dB re 1 N²/Hz", words, added))
    if curves.incoherent is not None:
        words = "What is not coherent with the force: noise, leakage, what is not linear"
        figures.append(_figure(curves, curves.incoherent, "dB re 1 (m/s²)²/Hz", words, added))
    if not any(figures):
        return ""
    return (
        f'<h2>Auto spectra</h2><p class="soft">{legend(added)}</p><div class="two">{"".join(figures)}</div>'
    )


def _residual(spectra: Spectra, predicted: FloatArray, good: BoolArray) -> FloatArray:
    ratio = np.log(np.where(good, spectra.measured, 1.0) / np.where(good, predicted, 1.0))
    return np.asarray(np.abs(ratio) / spectra.random_error)


def _figure(curves: Curves, spectra: Spectra, unit: str, words: str, added: bool) -> str:
    """Return the channel that is furthest off as given, level above difference; nothing if none is."""
    lowest = np.minimum(np.minimum(spectra.measured, spectra.before), spectra.after)
    good = (curves.freq > 0)[:, None] & (lowest > 0)
    gap = (_residual(spectra, spectra.before, good) ** 2).mean(axis=0)
    i = int(gap.argmax())
    if gap[i] < TELLING:
        return ""
    seen = good[:, i]
    name = f"{words}, {_channel(curves, spectra, i)}"
    levels = [
        np.where(seen, 10 * np.log10(np.where(seen, values[:, i], 1.0)), np.nan)
        for values in (spectra.measured, spectra.before, spectra.after)
    ]
    x, (measured, before, after) = svg.thinned(curves.freq, levels, POINTS)
    drawn = np.concatenate([one[np.isfinite(one)] for one in (measured, before, after)])
    low, high = np.floor(drawn.min() / 5) * 5, np.ceil((drawn.max() + 0.1) / 5) * 5
    bare = svg.linear(float(curves.freq[0]), float(curves.freq[-1]), "")
    frame = svg.Frame(bare, svg.linear(low, high, unit, n_ticks=5), height=190.0)
    marks = [
        svg.line(frame, x, measured, "measured"),
        svg.line(frame, x, before, "before"),
        svg.line(frame, x, after, "after") if added else "",
    ]
    pictures = svg.chart(frame, name, marks) + _difference(curves, spectra, i, good, name, added)
    return f"<figure>{pictures}<figcaption>{escape(name)}.</figcaption></figure>"


def _difference(curves: Curves, spectra: Spectra, i: int, good: BoolArray, name: str, added: bool) -> str:
    before, after = (
        np.where(good[:, i], _residual(spectra, predicted, good)[:, i], np.nan)
        for predicted in (spectra.before, spectra.after)
    )
    return differences(curves.freq, before, after, f"{name}: difference in random errors", added)


def _channel(curves: Curves, spectra: Spectra, i: int) -> str:
    """Return what a spectrum was measured with: a run of a roving accelerometer goes by its response."""
    n = spectra.measured.shape[1]
    return f"response {curves.outputs[i]}" if n == len(curves.outputs) else "of all responses at once"
