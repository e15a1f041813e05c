"""What a diagnosis hands over."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

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


@dataclass(frozen=True)
class Located:
    """Where the model without additions parts from the measurement."""

    bands: tuple[tuple[float, float], ...] = ()  # Hz
    dofs: tuple[Dof, ...] = ()
    modes: tuple[int, ...] = ()  # elastic modes of the model, from 1
    words: tuple[str, ...] = ()


@dataclass(frozen=True)
class NextTest:
    """The further measurement that would separate what this one cannot."""

    why: str
    change: Mapping[str, object]
    separates: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Curves:
    """The FRFs that the diagnosis compared, H1 as inertance."""

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
    seed: int | None = None
    notes: tuple[str, ...] = field(default=())
