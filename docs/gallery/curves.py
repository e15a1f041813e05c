"""The curves of a picture: expected measurements without and with the effect."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from docs.gallery.example import Example, structure
from docs.gallery.examples import example_of
from modallab.api.rigs.schemas import RigIn
from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement

LINES = 801
FINEST = 4  # times as many lines at most, where a narrow band is drawn
# What the eye finds in a picture: a change of |H| or a spectrum, dB, of phase, degrees, of coherence.
VISIBLE = {"magnitude": 0.2, "ratio": 0.2, "force": 0.2, "response": 0.2, "phase": 1.0, "turn": 1.0}
VISIBLE |= {"coherence": 0.01}
TOUCHABLE = ("magnitude", "phase", "coherence", "force", "response")
TOUCH_LINES = 401  # enough for the resonances of every band to show, and quick
CHOICE = ("magnitude", "phase", "coherence", "force")  # where an example names no panels


@dataclass(frozen=True)
class Curve:
    """A measurement with the effect, what the legend calls it, and the same one without the effect."""

    label: str
    measurement: Measurement
    bare: Measurement


@dataclass(frozen=True)
class Panel:
    """One quantity of one response."""

    quantity: str
    output: Dof

    def of(self, measurement: Measurement, reference: Measurement) -> FloatArray:
        """Return the quantity over frequency, (n_freq,): dB, degrees or 1."""
        row = measurement.frf.outputs.index(self.output)
        frf = measurement.frf.values[:, row, 0]
        if self.quantity in ("ratio", "turn"):
            frf = frf / reference.frf.values[:, row, 0]
        if self.quantity in ("phase", "turn"):
            return np.asarray(np.degrees(np.angle(frf)))
        if self.quantity in ("magnitude", "ratio"):
            return np.asarray(20 * np.log10(np.abs(frf).clip(min=1e-12)))
        if self.quantity == "force":
            assert measurement.force_spectrum is not None
            return np.asarray(10 * np.log10(measurement.force_spectrum[:, row, 0]))
        whole = measurement.coherence if self.quantity == "coherence" else measurement.response_spectrum
        assert whole is not None
        values = whole.reshape(len(whole), len(measurement.frf.outputs), -1)[:, row, 0]
        return values if self.quantity == "coherence" else np.asarray(10 * np.log10(values))


@dataclass(frozen=True)
class Picture:
    """All curves of an effect, and the panels that they are drawn in."""

    kind: str
    example: Example
    reference: Measurement
    curves: tuple[Curve, ...]
    panels: tuple[Panel, ...]

    @property
    def freq(self) -> FloatArray:
        """(n_freq,) Hz."""
        return self.reference.frf.freq

    @property
    def shown(self) -> Any:
        """Which lines are drawn: without 0 Hz, where rounding is, and the last, where the signal ends."""
        return (self.freq > 0) & (self.freq >= self.example.band[0]) & (self.freq < self.freq[-1])

    def change(self, panel: Panel) -> float:
        """Return the largest change that the effect makes in a panel, in the panel's unit."""
        largest = 0.0
        for curve in self.curves:
            bare, loaded = (
                panel.of(measurement, curve.bare) for measurement in (curve.bare, curve.measurement)
            )
            step = np.abs(loaded - bare)[self.shown]
            if panel.quantity in ("phase", "turn"):  # 359 degrees are 1
                step = np.minimum(step, 360 - step)
            largest = max(largest, float(step.max()))
        return largest

    def visible(self, panel: Panel) -> bool:
        """Return whether the eye finds the change in a panel."""
        return self.change(panel) > VISIBLE[panel.quantity]


def merged(base: Mapping[str, Any], update: Mapping[str, Any]) -> dict[str, Any]:
    """Return a body with another one's parts in it, objects within objects too."""
    out = dict(base)
    for name, value in update.items():
        nested = isinstance(value, Mapping) and isinstance(out.get(name), Mapping)
        out[name] = merged(out[name], value) if nested else value
    return out


def rig_body(example: Example, n_lines: int = LINES) -> dict[str, Any]:
    """Return the log book of the test without the effect, as the service takes it."""
    low, top = example.band
    finer = min(round(top / (top - low)), FINEST)  # of what is drawn, not of what is measured
    analyser = {"frequency_max": top, "n_lines": (n_lines - 1) * finer + 1}
    plain = {"drive": "1:+Y", "responses": ["7:+Y"], "analyser": analyser}
    return merged(plain, example.rig)


def effect_body(kind: str) -> dict[str, Any]:
    """Return the effect of a picture, as the service takes it."""
    example = example_of(kind)
    return {"kind": kind, "at": example.at, "parameters": dict(example.parameters)}


@lru_cache(maxsize=256)
def picture(kind: str, n_lines: int = LINES) -> Picture:
    """Return the curves of an effect's picture.

    Parameters
    ----------
    n_lines
        Of the analyser; few make a quick, coarse picture.
    """
    example = example_of(kind)
    bare = rig_body(example, n_lines)
    more = {"effects": [effect_body(kind)]} if example.declared is None else example.declared
    loaded = merged(bare, more)
    curves = []
    for level in example.levels or (None,):
        loud = {} if level is None else {"analyser": {"excitation": {"level": level}}}
        label = "with" if level is None else f"with, {level:g} N"
        with_it, without = (_measured(example, merged(body, loud)) for body in (loaded, bare))
        curves.append(Curve(label, with_it, without))
    whole = Picture(kind, example, curves[0].bare, tuple(curves), ())
    return replace(whole, panels=_panels(whole))


def touched(kind: str) -> tuple[str, ...]:
    """Return which quantities the effect changes visibly at any response of its picture."""
    whole = picture(kind, TOUCH_LINES)
    outputs = whole.reference.frf.outputs
    return tuple(name for name in TOUCHABLE if any(whole.visible(Panel(name, output)) for output in outputs))


def _measured(example: Example, body: Mapping[str, Any]) -> Measurement:
    setup = RigIn.model_validate(body).to_domain()
    rng = np.random.default_rng(0)  # the expected route draws nothing from it
    return measure(structure(example.structure), setup, route=Route.EXPECTED, rng=rng)


def _panels(whole: Picture) -> tuple[Panel, ...]:
    last = whole.reference.frf.outputs[-1]
    if not whole.example.panels:
        size, phase, *other_panels = (Panel(name, last) for name in CHOICE)
        turned = [] if whole.visible(size) else [phase]  # a resonance that moves shows in its size
        return (size, *(panel for panel in (*turned, *other_panels) if whole.visible(panel)))
    panel_texts = [text.split() for text in whole.example.panels]
    return tuple(Panel(name, Dof.parse(dof_text[0]) if dof_text else last) for name, *dof_text in panel_texts)
