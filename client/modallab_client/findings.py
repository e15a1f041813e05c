"""What the lab finds out: updated models, diagnoses; and correlations, from `correlation`."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any

from modallab_client import _plots, _tables, identified
from modallab_client.correlation import Correlation as Correlation
from modallab_client.direct import DirectFindings as DirectFindings
from modallab_client.direct import Suspects as Suspects
from modallab_client.identified import Identifiability as Identifiability
from modallab_client.identified import Posterior as Posterior
from modallab_client.identified import Quantity as Quantity
from modallab_client.identified import Responses as Responses
from modallab_client.located import Located as Located
from modallab_client.models import ComplexArray, FloatArray

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from numpy.typing import NDArray


@dataclass(frozen=True)
class MacroCoefficient:
    """The coefficient that members share during an iteration."""

    part: str
    members: tuple[int, ...]
    value: float


@dataclass(frozen=True, eq=False)
class Iteration:
    """One step of an update."""

    stage: str  # location or updating
    coefficients: tuple[MacroCoefficient, ...]
    max_change: float | None
    rank: int | None
    condition_number: float | None
    frequencies: FloatArray  # (n_modes,) Hz, of the model at this step
    mac: FloatArray  # (n_modes,)


@dataclass(frozen=True, eq=False)
class Update:
    """A model brought closer to a test; coefficients multiply an element's matrix, 1 = no change.

    Those of damping are loss factors added to an element's own, 0 = no change.
    """

    id: str
    converged: bool
    stopped_because: str
    iterations: Mapping[str, int]  # of location and updating
    coefficients: Mapping[str, Mapping[int, float]]  # part -> member -> coefficient
    standard_errors: Mapping[str, Mapping[int, float]]
    suspected: Mapping[str, tuple[int, ...]]  # part -> members that location left over
    frequencies: Mapping[str, FloatArray]  # measured, before, location, after; Hz
    mac: Mapping[str, FloatArray]
    rank: int | None
    condition_number: float | None
    structure_id: str | None  # the updated model; None of direct methods, see `updates.matrices`
    history: tuple[Iteration, ...] = ()
    intervals: Mapping[str, Mapping[int, tuple[float, float]]] = field(default_factory=dict)  # 95 %, by data
    identifiability: Identifiability | None = None
    quantities: tuple[Quantity, ...] = ()  # properties in their own units
    responses: Responses | None = None  # of methods that take FRFs
    posterior: Posterior | None = None  # if draws were asked for
    direct: DirectFindings | None = None  # of methods that work on matrices
    suspects: Suspects | None = None  # of methods that locate errors by one step

    def table(self) -> str:
        """Return coefficients with standard errors and 95 % intervals, or the errors located, as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        if self.direct is not None:
            found = self.direct.dof_errors.items()
            errors = [(name, dof, f"{error:.3g}") for name, dofs in found for dof, error in dofs.items()]
            return ("matrix", "DoF", "relative error"), errors
        if self.suspects is not None:
            return ("part", "member", "change", "weight"), self.suspects.rows()
        rows = [
            (
                part,
                str(member),
                f"{value:.4g}",
                _error(self.standard_errors.get(part, {}).get(member)),
                identified.ends(self.intervals.get(part, {}).get(member)),
            )
            for part, members in self.coefficients.items()
            for member, value in members.items()
        ]
        return ("part", "member", "coefficient", "standard error", "95 % by the data"), rows

    def plot(self) -> "Axes":
        """Draw the coefficients by member, or errors by DoF; return the axes."""
        return _plots.update(self)

    def _repr_html_(self) -> str:
        return _tables.html(*self._rows(), caption=f"Update {self.id}: {self.stopped_because}")


def _error(value: float | None) -> str:
    return "" if value is None else f"{value:.2g}"


@dataclass(frozen=True)
class Parameter:
    """A fitted number of an effect."""

    value: float
    standard_error: float | None
    unit: str

    def __str__(self) -> str:
        unit = "" if self.unit in ("", "1") else f" {self.unit}"
        error = self.standard_error
        if error is None or not math.isfinite(error) or error <= 0:
            return f"{self.value:.4g}{unit}"
        power = math.floor(math.log10(max(abs(self.value), error)))
        scale = power if not -3 <= power <= 5 else 0
        digits = max(0, 1 - math.floor(math.log10(error / 10.0**scale)))  # two of the error
        text = f"{self.value / 10.0**scale:.{digits}f} ± {error / 10.0**scale:.{digits}f}"
        return f"({text})e{scale}{unit}" if scale else f"{text}{unit}"


@dataclass(frozen=True)
class Tolerated:
    """A number that may differ a little, as it was fitted: true over declared, or a delay in s."""

    name: str
    value: float
    standard_error: float | None
    tolerance: float  # one standard deviation, beforehand
    unit: str
    at: str | Mapping[str, Any] | None = None  # a channel of its own
    mode: int | None = None  # elastic mode of the model, from 1


@dataclass(frozen=True)
class FittedEffect:
    """An effect that was found: what, where, how much."""

    kind: str
    at: str | Mapping[str, Any] | None  # a DoF, {"members": [...]}, {"channels": [...]}, None: everywhere
    parameters: Mapping[str, Parameter]

    def __str__(self) -> str:
        numbers = ", ".join(f"{name} {number}" for name, number in self.parameters.items())
        return f"{named(self.kind, self.at)}: {numbers}" if numbers else named(self.kind, self.at)


@dataclass(frozen=True)
class Rival:
    """Another explanation; without numbers it is one this measurement cannot tell apart."""

    kind: str
    at: str | Mapping[str, Any] | None
    probability: float | None = None
    gap_after: float | None = None


@dataclass(frozen=True)
class Step:
    """One missing effect, added; gaps of 1 leave only random error."""

    effect: FittedEffect
    probability: float | None
    gap_before: float
    gap_after: float
    held_out_gap_before: float | None
    held_out_gap_after: float | None
    held_out_scatter: float | None  # random error of the last number if nothing more is missing
    rivals: tuple[Rival, ...] = ()
    rivals_alike: tuple[Rival, ...] = ()


@dataclass(frozen=True)
class NextTest:
    """The test that would tell more, and between what it decides."""

    why: str
    change: Mapping[str, Any]  # as `changed` of a follow-up takes it
    separates: tuple[str, ...] = ()
    expected_separation: float | None = None  # of the closest of them, in standard deviations


@dataclass(frozen=True)
class FollowUp:
    """A further test that was explained together with the first."""

    measurement_id: str
    changed: Mapping[str, Any]  # against the first test


@dataclass(frozen=True)
class Diagnosis:
    """What the model lacked, where, how sure, and what is left."""

    id: str
    verdict: str  # explained, nothing_missing, unexplained or ambiguous
    located: Located
    steps: tuple[Step, ...]
    remaining_gap: float | None
    gaps: Mapping[str, Any]  # frf, force, response; before and after
    next_test: NextTest | None
    structure_id: str | None  # the model with what was added
    rig_id: str | None  # the rig with what was added
    remaining_scatter: float | None = None  # random error of the remaining gap if nothing is missing
    follow_ups: tuple[FollowUp, ...] = ()  # those sent, and those that `act` has run
    notes: tuple[str, ...] = ()
    tolerated: tuple[Tolerated, ...] = ()
    curves: "DiagnosisCurves | None" = field(default=None, repr=False, compare=False)

    def table(self) -> str:
        """Return effect, place, probability and gaps of each step as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        head = ("step", "effect", "probability", "gap before", "gap after", "held out before", "after")
        rows = []
        for number, step in enumerate(self.steps, 1):
            numbers = (step.probability, step.gap_before, step.gap_after)
            held_out = (step.held_out_gap_before, step.held_out_gap_after)
            cells = ("" if x is None else f"{x:.4g}" for x in (*numbers, *held_out))
            rows.append((str(number), str(step.effect), *cells))
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
        return _plots.diagnosis(self)

    def _repr_html_(self) -> str:
        left = "" if self.remaining_gap is None else f", remaining gap {self.remaining_gap:.3g}"
        verdict = self.verdict.replace("_", " ")
        table = _tables.html(*self._rows(), caption=f"Diagnosis {self.id}: {verdict}{left}")
        return table + "".join(f"<p>{escape(text)}</p>" for text in self.left_open())

    def left_open(self) -> list[str]:
        """Return in sentences what this test cannot tell apart, and which test could."""
        told = [
            f"This test cannot tell {named(step.effect.kind, step.effect.at)} from "
            f"{' or '.join(named(other.kind, other.at) for other in step.rivals_alike)}."
            for step in self.steps
            if step.rivals_alike
        ]
        if self.next_test is not None:
            change = ", ".join(f"{name} {value}" for name, value in self.next_test.change.items())
            told.append(f"Next test: {change.replace('_', ' ')}; {self.next_test.why}.")
        return told


@dataclass(frozen=True, eq=False)
class DiagnosisCurves:
    """The FRFs of a diagnosis: measured, predicted before and after what was added."""

    freq: FloatArray  # (n,) Hz
    measured: ComplexArray  # (n, n_out, n_in)
    before: ComplexArray
    after: ComplexArray
    random_error: FloatArray  # of |H|, relative
    held_out: "NDArray[np.bool_]"  # (n_out,)
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    predicted: ComplexArray | None = None  # (n, n_pred, n_in) at DoFs that were not measured
    predicted_outputs: tuple[str, ...] = ()

    def plot(self, output: str | None = None) -> "Axes":
        """Draw one response, by default the first: measured, before and after; return the axes."""
        return _plots.curves(self, self.outputs[0] if output is None else output)


def named(kind: str, at: str | Mapping[str, Any] | None) -> str:
    """Return kind and place of an effect in words."""
    name = kind.replace("_", " ")
    return name if at is None else f"{name} at {place(at)}"


def place(at: str | Mapping[str, Any] | None) -> str:
    """Return in words where an effect sits."""
    if at is None:
        return "everywhere"
    if isinstance(at, str):
        return at
    return "; ".join(
        f"{name if len(where) > 1 else name.removesuffix('s')} {', '.join(map(str, where))}"
        for name, where in at.items()
    )
