"""The curves of a picture: expected measurements without and with the effect."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
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
# What the eye finds in a picture: a change of |H| or a spectrum, dB, of phase, degrees, of coherence.
VISIBLE = {"magnitude": 0.2, "ratio": 0.2, "force": 0.2, "response": 0.2, "phase": 1.0, "turn": 1.0}
VISIBLE |= {"coherence": 0.01}
CHOICE = ("magnitude", "phase", "coherence", "force")  # where an example names no panels


@dataclass(frozen=True)
class Curve:
    """One measurement and what the legend calls it."""

    label: str
    measurement: Measurement


@dataclass(frozen=True)
class Panel:
    """One quantity of one response."""

    quantity: str
    output: Dof

    def of(self, measurement: Measurement, before: Measurement) -> FloatArray:
        """Return the quantity over frequency, (n_freq,): dB, degrees or 1."""
        row = measurement.frf.outputs.index(self.output)
        found = measurement.frf.values[:, row, 0]
        if self.quantity in ("ratio", "turn"):
            found = found / before.frf.values[:, row, 0]
        if self.quantity in ("phase", "turn"):
            return np.asarray(np.degrees(np.angle(found)))
        if self.quantity in ("magnitude", "ratio"):
            return np.asarray(20 * np.log10(np.abs(found).clip(min=1e-12)))
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
    before: Measurement
    after: tuple[Curve, ...]
    panels: tuple[Panel, ...]

    @property
    def freq(self) -> FloatArray:
        """(n_freq,) Hz."""
        return self.before.frf.freq

    @property
    def shown(self) -> Any:
        """Which lines lie in the band that is drawn; at rest there is rounding and nothing else."""
        return (self.freq > 0) & (self.freq >= self.example.band[0])

    def change(self, panel: Panel) -> float:
        """Return the largest change that the effect makes in a panel, in the panel's unit."""
        bare = panel.of(self.before, self.before)
        largest = 0.0
        for curve in self.after:
            step = np.abs(panel.of(curve.measurement, self.before) - bare)[self.shown]
            if panel.quantity in ("phase", "turn"):  # 359 degrees are 1
                step = np.minimum(step, 360 - step)
            largest = max(largest, float(step.max()))
        return largest

    def visible(self, panel: Panel) -> bool:
        """Return whether the eye finds the change in a panel."""
        return self.change(panel) > VISIBLE[panel.quantity]


def merged(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Return a body with another one's parts in it, objects within objects too."""
    out = dict(below)
    for name, value in above.items():
        both = isinstance(value, Mapping) and isinstance(out.get(name), Mapping)
        out[name] = merged(out[name], value) if both else value
    return out


def rig_body(example: Example, n_lines: int = LINES) -> dict[str, Any]:
    """Return the log book of the test without the effect, as the service takes it."""
    analyser = {"frequency_max": example.band[1], "n_lines": n_lines}
    plain = {"drive": "1:+Y", "responses": ["7:+Y"], "analyser": analyser}
    return merged(plain, example.rig)


def effect_body(kind: str) -> dict[str, Any]:
    """Return the effect of a picture, as the service takes it."""
    example = example_of(kind)
    return {"kind": kind, "at": example.at, "parameters": dict(example.parameters)}


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
    after = [Curve("with", _measured(example, loaded))]
    if example.levels:
        at = [{"analyser": {"excitation": {"level": level}}} for level in example.levels]
        labels = [f"with, {level:g} N" for level in example.levels]
        after = [Curve(la, _measured(example, merged(loaded, le))) for la, le in zip(labels, at, strict=True)]
    before = _measured(example, bare)
    whole = Picture(kind, example, before, tuple(after), ())
    return replace(whole, panels=_panels(whole))


def _measured(example: Example, body: Mapping[str, Any]) -> Measurement:
    setup = RigIn.model_validate(body).to_domain()
    rng = np.random.default_rng(0)  # the expected route draws nothing from it
    return measure(structure(example.structure), setup, route=Route.EXPECTED, rng=rng)


def _panels(whole: Picture) -> tuple[Panel, ...]:
    last = whole.before.frf.outputs[-1]
    if not whole.example.panels:
        size, phase, *others = (Panel(name, last) for name in CHOICE)
        turned = [] if whole.visible(size) else [phase]  # a resonance that moves shows in its size
        return (size, *(panel for panel in (*turned, *others) if whole.visible(panel)))
    named = [text.split() for text in whole.example.panels]
    return tuple(Panel(name, Dof.parse(where[0]) if where else last) for name, *where in named)
