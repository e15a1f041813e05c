"""Diagnoses: their effects in words, tables, pictures and curves."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from html import escape
from typing import TYPE_CHECKING, Any, cast

from modallab_client import _plots, _tables
from modallab_client._numbers import concise, gap
from modallab_client.models import ComplexArray, FloatArray

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from modallab_client._generated.models import Diagnosis, FittedParameter, NextTest, Step, Unknown

_MOST_NAMED = 4  # channels that are named one by one


@dataclass(frozen=True, eq=False)
class FrfCurves:
    """The FRFs of a diagnosis side by side, of one drive point after the other."""

    freq: FloatArray
    """(n,) Hz"""
    measured: ComplexArray
    """(n, n_frf)"""
    before: ComplexArray
    after: ComplexArray
    random_error: FloatArray
    """of |H|, relative"""
    held_out: "NDArray[np.bool_]"
    """(n_frf,)"""
    outputs: tuple[str, ...]
    """response of each FRF"""
    inputs: tuple[str, ...]
    """drive point of each FRF"""

    @property
    def names(self) -> tuple[str, ...]:
        """The responses; with several drive points response and drive point of each FRF."""
        if len(set(self.inputs)) == 1:
            return self.outputs
        return tuple(f"{out} / {drive}" for out, drive in zip(self.outputs, self.inputs, strict=True))


@dataclass(frozen=True, eq=False)
class DiagnosisCurves:
    """The FRFs of a diagnosis: measured, predicted before and after what was added."""

    freq: FloatArray
    """(n,) Hz"""
    measured: ComplexArray
    """(n, n_out, n_in)"""
    before: ComplexArray
    after: ComplexArray
    random_error: FloatArray
    """of |H|, relative"""
    held_out: "NDArray[np.bool_]"
    """(n_out,), (n_out, n_in) with several drive points"""
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    predicted: ComplexArray | None = None
    """(n, n_pred, n_in) at DoFs that were not measured"""
    predicted_outputs: tuple[str, ...] = ()

    def by_frf(self) -> FrfCurves:
        """Return the FRFs side by side."""
        n_out, n_in = len(self.outputs), len(self.inputs)

        def flat(array: "NDArray[Any]") -> "NDArray[Any]":
            return array.swapaxes(1, 2).reshape(len(self.freq), -1)

        return FrfCurves(
            self.freq,
            flat(self.measured),
            flat(self.before),
            flat(self.after),
            flat(self.random_error),
            self.held_out.T.ravel(),
            self.outputs * n_in,
            tuple(drive for drive in self.inputs for _ in range(n_out)),
        )

    def plot(self, output: str | None = None, drive: str | None = None) -> "Axes":
        """Draw one FRF, by default the first: measured, before and after; return the axes."""
        return _plots.curves(self, output or self.outputs[0], drive or self.inputs[0])


class FittedParameterMethods:
    """A fitted parameter prints with its standard error and unit."""

    if TYPE_CHECKING:
        value: float | None
        standard_error: float | None
        unit: str

    def in_short(self) -> str:
        """Return the value with its standard error in the last digits, and the unit: `0.010619(7) kg`."""
        if self.value is None:
            return str(self)
        unit = "" if self.unit in ("", "1") else f" {self.unit}"
        return f"{concise(self.value, self.standard_error)}{unit}"

    def __str__(self) -> str:
        if self.value is None:
            return "needs a level"
        unit = "" if self.unit in ("", "1") else f" {self.unit}"
        error = self.standard_error
        if error is None or not math.isfinite(error) or error <= 0:
            return f"{self.value:.4g}{unit}"
        power = math.floor(math.log10(max(abs(self.value), error)))
        scale = power if not -3 <= power <= 5 else 0
        digits = max(0, 1 - math.floor(math.log10(error / 10.0**scale)))  # two of the error
        text = f"{self.value / 10.0**scale:.{digits}f} ± {error / 10.0**scale:.{digits}f}"
        return f"({text})e{scale}{unit}" if scale else f"{text}{unit}"


class FittedEffectMethods:
    """A fitted effect prints as kind, place and parameters."""

    if TYPE_CHECKING:
        kind: str
        at: str | Mapping[str, Any] | None
        parameters: Mapping[str, FittedParameter]

    def in_short(self) -> str:
        """Return kind, place and parameters, each with its standard error in the last digits."""
        numbers = (
            f"{name.replace('_', ' ')} {number.in_short()}" for name, number in self.parameters.items()
        )
        return ", ".join([effect_name(self.kind, self.at), *numbers])

    def __str__(self) -> str:
        numbers = ", ".join(f"{name} {number}" for name, number in self.parameters.items())
        return f"{effect_name(self.kind, self.at)}: {numbers}" if numbers else effect_name(self.kind, self.at)


@dataclass(frozen=True, eq=False, kw_only=True)
class DiagnosisMethods:
    """A diagnosis has its curves, a table and a picture."""

    curves: DiagnosisCurves | None = field(default=None, repr=False)
    """FRFs, measured and predicted; None: not loaded."""
    if TYPE_CHECKING:
        id: str
        verdict: Any
        steps: tuple[Step, ...]
        remaining_gap: float | None
        next_test: NextTest | None
        unknown: Unknown | None

    def summary(self) -> str:
        """Return verdict, kind, place and size of each effect, and the gap before and after, in sentences."""
        verdict = self.verdict.replace("_", " ").capitalize()
        left = "random error alone leaves 1"
        if not self.steps:
            remaining = (
                "" if self.remaining_gap is None else f" The gap is {gap(self.remaining_gap)}; {left}."
            )
            return f"{verdict}.{remaining}"
        effects = "; ".join(step.effect.in_short() for step in self.steps)
        first, last = self.steps[0].gap_before, self.steps[-1].gap_after
        gaps = f"falls from {_gap_text(first)} to {_gap_text(last)}"
        return f"{verdict}: {effects}. The gap between test and prediction {gaps}; {left}."

    def table(self) -> str:
        """Return effect, place, probability and gaps of each step as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        head = ("step", "effect", "probability", "gap before", "gap after", "held out before", "after")
        rows = []
        for number, step in enumerate(self.steps, 1):
            gaps = (step.gap_before, step.gap_after, step.held_out_gap_before, step.held_out_gap_after)
            probability = f"{step.probability:.3g}"
            rows.append((str(number), str(step.effect), probability, *map(_gap_text, gaps)))
        return head, rows

    def plot(self) -> "tuple[Axes, ...]":
        """Draw what was found; return the axes.

        The gap by step; with curves also where model and measurement part, by response and frequency,
        and magnitude and phase where the prediction as given is clearly off, measured, before and after.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        """
        return _plots.diagnosis(cast("Diagnosis", self))

    def _repr_html_(self) -> str:
        remaining = "" if self.remaining_gap is None else f", remaining gap {gap(self.remaining_gap)}"
        verdict = self.verdict.replace("_", " ")
        table = _tables.html(*self._rows(), caption=f"Diagnosis {self.id}: {verdict}{remaining}")
        return table + "".join(f"<p>{escape(text)}</p>" for text in self.left_open())

    def left_open(self) -> list[str]:
        """Return in sentences what this test cannot tell apart, and which test could."""
        sentences = [
            f"This test cannot tell {effect_name(step.effect.kind, step.effect.at)} from "
            f"{' or '.join(effect_name(rival.kind, rival.at) for rival in step.rivals_alike)}."
            for step in self.steps
            if step.rivals_alike
        ]
        if self.unknown is not None:
            unknown = self.unknown
            model = f", model: {unknown.curve_model.replace('_', ' ')}" if unknown.curve_model else ""
            sentences.append(
                f"An effect of no catalogue: {unknown.cause.replace('_', ' ')} at {place(unknown.at)}{model}."
            )
        if self.next_test is not None:
            change = ", ".join(f"{name} {value}" for name, value in self.next_test.change.items())
            sentences.append(f"Next test: {change.replace('_', ' ')}; {self.next_test.why}.")
        return sentences


def _gap_text(value: float | None) -> str:
    return "" if value is None else gap(value)


def effect_name(kind: str, at: str | Mapping[str, Any] | None) -> str:
    """Return kind and place of an effect in words."""
    name = kind.replace("_", " ")
    return name if at is None else f"{name} at {place(at)}"


def place(at: str | Mapping[str, Any] | None) -> str:
    """Return in words where an effect sits."""
    if at is None:
        return "everywhere"
    if isinstance(at, str):
        return at
    return "; ".join(_counted(name, list(map(str, where))) for name, where in at.items())


def _counted(name: str, where: list[str]) -> str:
    """Return a plural with what it counts, each by name; of many channels number, first and last."""
    if name == "channels" and len(where) > _MOST_NAMED:
        return f"{len(where)} {name}, {where[0]} to {where[-1]}"
    return f"{name if len(where) > 1 else name.removesuffix('s')} {', '.join(where)}"


def diagnosis_curves(arrays: Mapping[str, "NDArray[Any]"]) -> DiagnosisCurves:
    """Return the curves of a diagnosis from the arrays of its npz file."""
    texts = ("outputs", "inputs", "predicted_outputs")
    curve_arrays: dict[str, Any] = {
        f.name: arrays[f.name] for f in fields(DiagnosisCurves) if f.name in arrays
    }
    return DiagnosisCurves(
        **curve_arrays | {name: tuple(map(str, curve_arrays[name])) for name in texts if name in curve_arrays}
    )
