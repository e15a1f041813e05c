"""Result of a diagnosis: verdict, location of the disagreement, missing effects, remaining gap."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from modallab.core.dof import Dof
from modallab.core.place import Place
from modallab.core.reply import NanFloat
from modallab.diagnosis.result_curves import DiagnosisCurves
from modallab.diagnosis.result_localisation import Localisation
from modallab.fe.structure import Structure
from modallab.rig.setup import RigSetup


class Verdict(StrEnum):
    """Outcome of a diagnosis."""

    EXPLAINED = "explained"
    PARTLY_EXPLAINED = "partly_explained"
    NOTHING_MISSING = "nothing_missing"
    UNEXPLAINED = "unexplained"
    AMBIGUOUS = "ambiguous"


@dataclass(frozen=True)
class FittedParameter:
    """Parameter of an effect, as fitted, with its standard error."""

    value: NanFloat
    """In `unit`, the estimate; nan where it needs a level: of a nonlinear effect, the level unknown."""
    standard_error: NanFloat
    """In `unit`, random error of the estimate; nan where it cannot be stated."""
    unit: str
    """SI unit of value and standard error; `1` for a ratio."""


@dataclass(frozen=True)
class FittedEffect:
    """Effect with the parameters fitted to the measurement."""

    kind: str
    """Kind of effect, as the catalogue of effects names it."""
    at: Place
    """Place of the effect; None: the whole structure or the whole rig."""
    parameters: Mapping[str, FittedParameter]
    """Fitted parameters by name."""


@dataclass(frozen=True)
class ToleratedParameter:
    """Nuisance parameter, free within its tolerance and fitted beside the missing effects."""

    name: str
    """Name as in `tolerances.Tolerances`."""
    value: float
    """Ratio true over declared; of a delay, s."""
    standard_error: NanFloat
    """In `unit`, random error of the value."""
    tolerance: float
    """In `unit`, prior standard deviation."""
    unit: str
    """Unit of value, error and tolerance; `1` for a ratio."""
    at: Place = None
    """Channel or member to which the parameter belongs; None: all."""
    mode: int | None = None
    """Elastic mode of the model to which the parameter belongs, counted from 1; None: no mode."""


@dataclass(frozen=True)
class Rival:
    """Competing explanation of the same round."""

    kind: str
    """Kind of effect."""
    at: Place
    """Place of the effect."""
    probability: NanFloat
    """Posterior probability among the explanations of its round, 0 to 1."""
    gap_after: NanFloat
    """Gap (mean squared residual) that remains with this effect on the fitted FRFs."""


@dataclass(frozen=True)
class EquivalentEffect:
    """Effect that this measurement cannot distinguish from the named one."""

    kind: str
    """Kind of effect."""
    at: Place
    """Place of the effect."""


@dataclass(frozen=True)
class Step:
    """Effect added to the model, and the reduction of the gap; held-out FRFs took no part in the fit."""

    effect: FittedEffect
    """The added effect, with parameters from the fit of all effects together."""
    probability: NanFloat
    """Posterior probability among the explanations of its round, 0 to 1."""
    gap_before: NanFloat
    """Gap (mean squared residual) over the fitted FRFs before the effect was added."""
    gap_after: NanFloat
    """Gap over the fitted FRFs with the effect."""
    held_out_gap_before: NanFloat
    """Gap over the held-out FRFs before the effect was added."""
    held_out_gap_after: NanFloat
    """Gap over the held-out FRFs with the effect."""
    held_out_scatter: NanFloat
    """Standard deviation of `held_out_gap_after` if no other effect is missing."""
    rivals: tuple[Rival, ...] = ()
    """Competing explanations of the round, best first, without the named one."""
    rivals_alike: tuple[EquivalentEffect, ...] = ()
    """Effects that this measurement cannot distinguish from the named one."""


@dataclass(frozen=True)
class DetectionLimit:
    """Smallest amount of a kind of effect that the test would have shown in almost all cases."""

    kind: str
    """Kind of effect."""
    parameter: str
    """Parameter that is the amount of the effect."""
    unit: str
    """SI unit of the amounts; `1` for a ratio."""
    smallest: float
    """In `unit`, deviation of the parameter from that of no effect, at the most visible place."""
    at: Place
    """Most visible place."""
    largest: float
    """In `unit`, the same at the least visible place."""
    least_visible_at: Place
    """Least visible place."""
    invisible_places: int = 0
    """Places where the test would show no amount within the parameter's bounds."""


class UnknownCause(StrEnum):
    """What an unknown effect acts as."""

    INTERNAL_FORCE = "internal_force"  # force on one DoF of the structure
    CHANNEL_GAIN = "channel_gain"  # gain of one response channel
    COMMON_GAIN = "common_gain"  # gain of all channels, or force at the drive point


class CurveModelName(StrEnum):
    """Parametric model of the curve of an unknown effect."""

    SPRING = "spring"
    MASS = "mass"
    DAMPER = "damper"
    HYSTERETIC_SPRING = "hysteretic_spring"  # spring with a loss factor
    SPRING_AND_DAMPER = "spring_and_damper"  # in parallel
    POWER = "power"  # of i omega, as of a fractional derivative
    OSCILLATOR = "oscillator"  # mass on a spring with a loss factor
    TWO_OSCILLATORS = "two_oscillators"  # side by side on one point
    DELAYED_DISPLACEMENT_FEEDBACK = "delayed_displacement_feedback"
    DELAYED_VELOCITY_FEEDBACK = "delayed_velocity_feedback"
    DELAYED_ACCELERATION_FEEDBACK = "delayed_acceleration_feedback"
    GAIN = "gain"  # constant
    FIRST_ORDER_HIGH_PASS = "first_order_high_pass"
    FIRST_ORDER_LOW_PASS = "first_order_low_pass"
    DELAY = "delay"


@dataclass(frozen=True)
class CurvePoint:
    """Value of an unknown effect's curve at one frequency."""

    frequency: float
    """Hz."""
    real: float
    """Real part, in the unit of the curve."""
    imaginary: float
    """Imaginary part, in the unit of the curve."""
    standard_error: NanFloat
    """Random error of the real and of the imaginary part, in the unit of the curve."""


@dataclass(frozen=True)
class UnknownRival:
    """Place at which an unknown effect explains the measurement as well."""

    cause: UnknownCause
    """What the effect acts as."""
    at: Place
    """Place of the effect; None: all channels."""


@dataclass(frozen=True)
class Unknown:
    """Effect of no catalogue, solved for line by line: its place, its curve, and a model of the curve."""

    cause: UnknownCause
    """What the effect acts as."""
    at: Place
    """DoF of the force, or channel; None: all channels."""
    curve: tuple[CurvePoint, ...]
    """Dynamic stiffness from the DoF to the ground, or gain true over declared, at most one for ten lines."""
    unit: str
    """Unit of the curve: N/m or N m/rad; `1` for a gain."""
    curve_model: CurveModelName | None
    """Parametric model that the curve follows; None: none of those tried."""
    source: Dof | None
    """DoF whose motion the force follows by that model; None: not a force, or no model."""
    parameters: Mapping[str, FittedParameter]
    """Parameters of the curve model by name."""
    gap_before: NanFloat
    """Gap of the fitted FRFs without it: with the added effects if it acts beside them."""
    gap_after: NanFloat
    """Gap of the fitted FRFs with the curve."""
    held_out_gap_before: NanFloat
    """Gap of the held-out FRFs without it, likewise; nan where none was measured."""
    held_out_gap_after: NanFloat
    """Gap of the held-out FRFs with the curve."""
    beside_steps: bool
    """Whether it acts beside the added effects; otherwise alone, in their place."""
    rivals_alike: tuple[UnknownRival, ...] = ()
    """Other places that this measurement cannot distinguish from the named one."""


@dataclass(frozen=True)
class NextTest:
    """Proposed further test that would distinguish explanations which this measurement cannot."""

    why: str
    """Reason for the proposal, in plain English."""
    change: Mapping[str, object]
    """Changes against the first test, as `rig.change.Change.read` reads them."""
    separates: tuple[str, ...]
    """Kinds of effects that the test distinguishes."""
    expected_separation: NanFloat = float("nan")
    """Standard deviations, expected difference of the two closest explanations."""


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Disagreement of model and measurement, the missing effects, and the gap that remains."""

    verdict: Verdict
    """Outcome of the diagnosis."""
    located: Localisation
    """Location of the disagreement without added effects."""
    steps: tuple[Step, ...]
    """Added effects, the one that explains most first."""
    remaining_gap: NanFloat
    """Gap (mean squared residual) over all usable FRFs with all added effects; 1: random error alone."""
    remaining_scatter: NanFloat
    """Standard deviation of `remaining_gap` if no effect is missing."""
    gaps: Mapping[str, Mapping[str, NanFloat]]
    """Gap of each part (FRFs, force spectra, response spectra) under `before` and `after`."""
    structure: Structure
    """Model with the added effects."""
    setup: RigSetup
    """Log book with the added effects."""
    curves: DiagnosisCurves
    """Measured and predicted FRFs and spectra."""
    candidates: tuple[Rival, ...] = ()
    """All effects fitted in the first round, best first."""
    detection_limits: tuple[DetectionLimit, ...] = ()
    """Smallest amounts that the test would have shown beside the added effects; empty if a gap remains."""
    unknown: Unknown | None = None
    """Effect of no catalogue that closes most of a remaining gap; None: no gap remains, or none does."""
    next_test: NextTest | None = None
    """Proposed further test; None: no rival is left."""
    tolerated: tuple[ToleratedParameter, ...] = ()
    """Nuisance parameters that were free within their tolerances."""
    follow_ups: tuple[Mapping[str, object], ...] = ()
    """Changes of each further test against the first."""
    seed: int | None = None
    """Seed from which the held-out FRFs were drawn."""
    request_options: Mapping[str, object] = field(default_factory=dict)
    """Options of the request, to repeat it."""
    notes: tuple[str, ...] = field(default=())
    """Limitations of this diagnosis, in plain English."""
