"""What a diagnosis hands over."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, frozen
from modallab.core.dof import Dof
from modallab.core.place import Place
from modallab.fe.structure import Structure
from modallab.rig.setup import RigSetup


class Verdict(StrEnum):
    """How a diagnosis ends."""

    EXPLAINED = "explained"
    NOTHING_MISSING = "nothing_missing"
    UNEXPLAINED = "unexplained"
    AMBIGUOUS = "ambiguous"


@dataclass(frozen=True)
class FittedParameter:
    """A fitted number with its random error."""

    value: float
    standard_error: float
    unit: str


@dataclass(frozen=True)
class FittedEffect:
    """An effect with the size that the measurement gives it."""

    kind: str
    at: Place
    parameters: Mapping[str, FittedParameter]


@dataclass(frozen=True)
class Tolerated:
    """A number that may differ a little, as it was fitted beside what was missing."""

    name: str  # as `tolerances.Tolerances` has it
    value: float  # true over declared; of a delay, s
    standard_error: float
    tolerance: float  # one standard deviation, beforehand
    unit: str
    at: Place = None  # a channel of its own
    mode: int | None = None  # elastic mode of the model, from 1


@dataclass(frozen=True)
class Rival:
    """Another explanation, and what it leaves unexplained."""

    kind: str
    at: Place
    probability: float
    gap_after: float


@dataclass(frozen=True)
class Alias:
    """An explanation that this measurement cannot tell from the one named."""

    kind: str
    at: Place


@dataclass(frozen=True)
class Step:
    """One effect added to the model, and what it closed; held-out FRFs took no part in the fit."""

    effect: FittedEffect
    probability: float
    gap_before: float
    gap_after: float
    held_out_gap_before: float
    held_out_gap_after: float
    held_out_scatter: float  # random error of the last number if nothing more is missing
    rivals: tuple[Rival, ...] = ()
    rivals_alike: tuple[Alias, ...] = ()


class Sign(StrEnum):
    """What is telling about where a gap sits."""

    FORCE_ONLY = "force_only"  # FRFs and what is not coherent agree
    COHERENCE_ONLY = "coherence_only"  # FRFs and forces agree
    ONE_RESPONSE = "one_response"  # all others agree
    DRIVE_POINT_ONLY = "drive_point_only"
    LOW_FREQUENCY = "low_frequency"  # in the lowest quarter of the band alone
    HIGH_FREQUENCY = "high_frequency"  # in the highest quarter
    LEVEL_DEPENDENCE = "level_dependence"  # tests at other force levels differ


@dataclass(frozen=True)
class ModeShift:
    """How a resonance differs from the model's, with standard errors; nan where the test does not tell."""

    mode: int  # elastic modes of the model, from 1
    frequency: float  # Hz, of the model
    frequency_shift: float  # measured over the model's, minus 1
    frequency_error: float
    loss_factor_shift: float  # the same of the loss factor
    loss_factor_error: float


class Course(StrEnum):
    """How a response differs over frequency."""

    GAIN = "gain"  # by a factor
    POLARITY = "polarity"  # by the sign
    DELAY = "delay"  # by a phase that grows with frequency
    RISING_GAIN = "rising_gain"  # by a factor that grows with the square of frequency


@dataclass(frozen=True)
class ResponseMisfit:
    """How the FRF of one response differs, on average over all lines, with standard errors."""

    dof: Dof
    gap: float  # mean squared residual
    amplitude: float  # measured over predicted
    amplitude_error: float
    phase: float  # rad, measured minus predicted
    phase_error: float
    delay: float  # s by which the measured one lags behind
    delay_error: float
    course: Course | None = None  # what accounts for nearly all of its gap; None: not one of these alone


@dataclass(frozen=True)
class Located:
    """Where the model without additions parts from the measurement."""

    bands: tuple[tuple[float, float], ...] = ()  # Hz
    dofs: tuple[Dof, ...] = ()
    modes: tuple[int, ...] = ()  # elastic modes of the model, from 1
    words: tuple[str, ...] = ()
    signs: tuple[Sign, ...] = ()
    mode_shifts: tuple[ModeShift, ...] = ()
    responses: tuple[ResponseMisfit, ...] = ()
    level_dependence: float | None = None  # gap between tests at two levels; None: one level only


@dataclass(frozen=True)
class NextTest:
    """The further measurement that would separate what this one cannot."""

    why: str
    change: Mapping[str, object]  # as `rig.change.Change.read` reads it
    separates: tuple[str, ...]
    expected_separation: float = float("nan")  # of the two closest of them, in standard deviations


@dataclass(frozen=True, eq=False)
class Spectra:
    """An auto spectrum that the diagnosis compared, one-sided."""

    measured: FloatArray  # (n_freq, n_channel) unit^2/Hz
    before: FloatArray  # the same, predicted without additions
    after: FloatArray  # the same, with what was added
    random_error: FloatArray  # (n_freq, n_channel) of its logarithm

    def __post_init__(self) -> None:
        for name in ("measured", "before", "after", "random_error"):
            object.__setattr__(
                self, name, frozen(getattr(self, name), float, np.shape(self.measured), name=name)
            )


@dataclass(frozen=True, eq=False)
class Curves:
    """The FRFs that the diagnosis compared, H1 as inertance, and the auto spectra where measured."""

    freq: FloatArray  # (n_freq,) Hz
    measured: ComplexArray  # (n_freq, n_out, n_in) m/(s^2 N)
    before: ComplexArray  # the same, predicted without additions
    after: ComplexArray  # the same, with what was added
    random_error: FloatArray  # (n_freq, n_out, n_in) of |H|, relative
    held_out: BoolArray  # (n_out,)
    outputs: tuple[Dof, ...]
    inputs: tuple[Dof, ...]
    predicted: ComplexArray | None = None  # (n_freq, n_pred, n_in) at DoFs that were not measured
    predicted_outputs: tuple[Dof, ...] = ()
    force: Spectra | None = None  # of each run, N^2/Hz
    incoherent: Spectra | None = None  # of each response, what is not coherent with the force, (m/s^2)^2/Hz

    def __post_init__(self) -> None:
        shape = (len(self.freq), len(self.outputs), len(self.inputs))
        for name in ("measured", "before", "after"):
            object.__setattr__(self, name, frozen(getattr(self, name), complex, shape, name=name))
        object.__setattr__(self, "freq", frozen(self.freq, float, shape[:1], name="freq"))
        errors = frozen(self.random_error, float, shape, name="random_error")
        object.__setattr__(self, "random_error", errors)
        object.__setattr__(self, "held_out", frozen(self.held_out, bool, shape[1:2], name="held_out"))
        if self.predicted is not None:
            wanted = (shape[0], len(self.predicted_outputs), shape[2])
            predicted = frozen(self.predicted, complex, wanted, name="predicted")
            object.__setattr__(self, "predicted", predicted)


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Where model and measurement part, which effects were missing, and what is left."""

    verdict: Verdict
    located: Located
    steps: tuple[Step, ...]
    remaining_gap: float
    remaining_scatter: float  # expected random error of the remaining gap if nothing is missing
    gaps: Mapping[str, Mapping[str, float]]  # "before", "after" -> part -> mean squared residual
    structure: Structure  # the model with what was added
    setup: RigSetup  # the log book with what was added
    curves: Curves
    candidates: tuple[Rival, ...] = ()  # all that were fitted in the first round, best first
    next_test: NextTest | None = None
    tolerated: tuple[Tolerated, ...] = ()
    follow_ups: tuple[Mapping[str, object], ...] = ()  # what was changed for each further test
    seed: int | None = None
    asked: Mapping[str, object] = field(default_factory=dict)  # the request's options, to ask the same again
    notes: tuple[str, ...] = field(default=())
