"""What an updating method is, and what it returns."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from modallab.core.arrays import FloatArray, frozen
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel
from modallab.core.options import OptionSpec
from modallab.core.parameters import Parameterised, parameter
from modallab.core.progress import Progress, silent
from modallab.core.registry import Family
from modallab.fe.structure import Structure
from modallab.updating.identifiability import Identifiability
from modallab.updating.iteration import Iteration
from modallab.updating.modal_residuals import Balance
from modallab.updating.parameterisation import Parameterisation, Part
from modallab.updating.posterior import PosteriorSample
from modallab.updating.quantities import Quantity
from modallab.updating.responses.result import ResponseFit
from modallab.updating.sparse_bayes import Prior

REFUSED, REGULARISED = "refused", "regularised"
CHOICES: Mapping[str, OptionSpec] = {
    "prior": OptionSpec(
        "what is held likely before: sparse, few elements wrong; common, many a little; range, only bounds",
        choices=tuple(Prior),
        default=Prior.SPARSE.value,
    ),
    "underdetermined": OptionSpec(
        "an update with fewer measured numbers than coefficients",
        choices=(REFUSED, REGULARISED),
        default=REFUSED,
    ),
    "balance": OptionSpec(
        "rows divided by their size: those of eigenvalues alone, or both these and those of shapes",
        choices=tuple(Balance),
        default=Balance.EIGENVALUES.value,
    ),
}
SAMPLING = ("samples", "seed")
BELIEVING = ("prior", "underdetermined")
TWO_STAGE = (
    "location_tolerance",
    "suspect_threshold",
    "damping_threshold",
    "max_step",
    "n_shapes",
    "balance",
)


@dataclass(frozen=True)
class UpdateOptions(Parameterised):
    """How an update is run."""

    max_iterations: int = parameter(30, unit="-", lower=1, upper=1000, doc="steps of one stage, at most")
    location_tolerance: float = parameter(
        0.01, unit="-", lower=1e-12, upper=1.0, doc="largest change of a macro coefficient that ends stage 1"
    )
    tolerance: float = parameter(
        1e-4, unit="-", lower=1e-12, upper=1.0, doc="largest change of a coefficient that ends stage 2"
    )
    suspect_threshold: float = parameter(
        0.08, unit="-", lower=0.0, upper=10.0, doc="distance from 1 at which a macro element is suspected"
    )
    damping_threshold: float = parameter(
        0.008,
        unit="-",
        lower=0.0,
        upper=2.0,
        doc="loss factor from which the damping of a macro element is suspected",
    )
    max_step: float = parameter(
        0.3, unit="-", lower=1e-3, upper=10.0, doc="largest change of a coefficient in one step of stage 2"
    )
    n_shapes: int = parameter(
        1000,
        unit="-",
        lower=0,
        upper=1000,
        doc="lowest measured modes whose shapes count, of the others only the eigenvalue",
    )
    rank_jump: float = parameter(
        1e3, unit="-", lower=2.0, upper=1e15, doc="ratio of consecutive singular values that ends the rank"
    )
    min_mac: float = parameter(
        0.3, unit="-", lower=0.0, upper=1.0, doc="MAC below which a measured and a model mode do not pair"
    )
    identified_within: float = parameter(
        0.3,
        unit="-",
        lower=1e-6,
        upper=10.0,
        doc="relative standard error, by the data alone, above which a coefficient is told as not identified",
    )
    samples: int = parameter(
        0, unit="-", lower=0, upper=100_000, doc="draws from the posterior behind the update; 0: none"
    )
    seed: int = parameter(0, unit="-", lower=0, upper=2**63 - 1, doc="of these draws")
    prior: str = Prior.SPARSE.value
    underdetermined: str = REFUSED
    balance: str = Balance.EIGENVALUES.value

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, spec in CHOICES.items():
            if getattr(self, name) not in spec.choices:
                raise InvalidInputError(
                    f"there is no {name} {getattr(self, name)!r}",
                    field=name,
                    value=str(getattr(self, name)),
                    allowed=", ".join(spec.choices),
                )

    @classmethod
    def as_options(cls) -> dict[str, OptionSpec]:
        """Return what those who set the options are told: numbers, and what is chosen by name."""
        return {**super().as_options(), **CHOICES}


DEFAULTS = UpdateOptions()


@dataclass(frozen=True, eq=False)
class Stages:
    """One number a mode as measured, before the update, after location and after it."""

    before: FloatArray
    location: FloatArray  # as before the update where a method has no such stage
    after: FloatArray
    measured: FloatArray | None = None  # none for a MAC

    def __post_init__(self) -> None:
        for name in ("before", "location", "after", "measured"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, frozen(value, float, (None,), name=name))


@dataclass(frozen=True, eq=False)
class UpdateResult:
    """What an update found; coefficients are 1 where nothing is to be corrected, 0 of damping."""

    structure: Structure  # the updated model
    coefficients: Mapping[str, Mapping[int, float]]  # by part and member
    standard_errors: Mapping[str, Mapping[int, float]]  # of those that were corrected
    suspected: Mapping[str, tuple[int, ...]]  # members by part
    frequencies: Stages  # Hz, (n_modes,) each
    mac: Stages  # of measured modes with their partners, (n_modes,) each
    history: tuple[Iteration, ...]
    converged: bool
    stopped_because: str
    rank: int
    condition_number: float
    # by part and member: low and high end of what holds a coefficient with 95 %, by the data alone
    intervals: Mapping[str, Mapping[int, tuple[float, float]]] = field(default_factory=dict)
    identifiability: Identifiability | None = None  # None of a path that diverged
    responses: ResponseFit | None = None  # of a method that takes frequency responses
    quantities: tuple[Quantity, ...] = ()  # properties in their own units
    posterior: PosteriorSample | None = None  # if draws were asked for
    iterations: Mapping[str, int] = field(init=False)  # "location", "updating"

    def __post_init__(self) -> None:
        counted = {
            stage: sum(one.stage == stage for one in self.history) for stage in ("location", "updating")
        }
        object.__setattr__(self, "iterations", counted)


class Updater(Protocol):
    """Corrects a model until its modes are the measured ones."""

    def __call__(
        self,
        structure: Structure,
        parameterisation: Parameterisation,
        target: ModalModel,
        *,
        options: UpdateOptions = DEFAULTS,
        progress: Progress = silent,
    ) -> UpdateResult:
        """Return the updated model and how it was found."""
        ...


METHODS_HOME = "modallab.updating.methods"
UPDATERS: Family[Updater] = Family("updating method", home=METHODS_HOME)
# Parts that a method corrects where none are named, if these are not mass and stiffness.
PARTS: Family[tuple[Part, ...]] = Family("updating method", home=METHODS_HOME)

# Options that a method does without, if these are not those that choose a prior.
UNUSED_OPTIONS: Family[tuple[str, ...]] = Family("updating method", home=METHODS_HOME)


def options_of(method: str) -> dict[str, OptionSpec]:
    """Return the options that mean something to a method."""
    idle = {*BELIEVING, *SAMPLING}
    if method in UNUSED_OPTIONS:
        idle = set(UNUSED_OPTIONS[method])
    if Part.DAMPING not in parts_of(method):
        idle.add("damping_threshold")
    return {name: spec for name, spec in UpdateOptions.as_options().items() if name not in idle}


def parts_of(method: str) -> tuple[Part, ...]:
    """Return the parts that a method corrects where none are named."""
    if method in PARTS:
        return PARTS[method]
    return (Part.MASS, Part.STIFFNESS)
