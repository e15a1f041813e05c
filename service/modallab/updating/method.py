"""Updating methods on modes or frequency responses: their interface and their result."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeVar

from modallab.core.arrays import FloatArray, frozen
from modallab.core.modal_model import ModalModel
from modallab.core.options import converted
from modallab.core.progress import Progress, silent
from modallab.core.registry import Family, first_line
from modallab.core.reply import NanFloat
from modallab.fe.structure import Structure
from modallab.updating.identifiability import Identifiability
from modallab.updating.iteration import Iteration
from modallab.updating.options import UpdateOptions
from modallab.updating.parameterisation import Parameterisation, Part
from modallab.updating.posterior import PosteriorSample
from modallab.updating.quantities import Quantity
from modallab.updating.responses.result import ResponseFit


@dataclass(frozen=True, eq=False)
class Stages:
    """Values of each measured mode: measured, before the update, after location and after the update."""

    before: FloatArray
    """Of the model before the update (n_modes,)."""
    location: FloatArray
    """After the location stage (n_modes,); as before where a method has none."""
    after: FloatArray
    """Of the updated model (n_modes,)."""
    measured: FloatArray | None = None
    """Measured (n_modes,); None for a modal assurance criterion."""

    def __post_init__(self) -> None:
        for name in ("before", "location", "after", "measured"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, frozen(value, float, (None,), name=name))

    @property
    def by_name(self) -> dict[str, FloatArray]:
        """Values by name of the stage, in the order of the update."""
        names = ("measured", "before", "location", "after")
        return {name: getattr(self, name) for name in names if getattr(self, name) is not None}


@dataclass(frozen=True, eq=False)
class UpdateResult:
    """Result of an update: coefficients are 1 where nothing is corrected, for damping 0."""

    structure: Structure
    """Updated model."""
    coefficients: Mapping[str, Mapping[int, float]]
    """Coefficients by part and member."""
    standard_errors: Mapping[str, Mapping[int, NanFloat]]
    """Standard errors of the corrected coefficients by part and member; None where undetermined."""
    suspected: Mapping[str, tuple[int, ...]]
    """Suspected members by part."""
    frequencies: Stages
    """Hz, natural frequencies of the paired modes."""
    mac: Stages
    """Modal assurance criterion of measured modes with their partners."""
    history: tuple[Iteration, ...]
    """Every step of both stages."""
    converged: bool
    """True if the last stage converged."""
    stopped_because: str
    """Reason for the end, for readers."""
    rank: int
    """Rank of the weighted sensitivity matrix at the end."""
    condition_number: NanFloat
    """Largest over smallest singular value within the rank."""
    intervals: Mapping[str, Mapping[int, tuple[float, float]]] = field(default_factory=dict)
    """95 % confidence intervals by the data alone, by part and member."""
    identifiability: Identifiability | None = None
    """Determination by the data alone; None for a diverged path."""
    responses: ResponseFit | None = None
    """Agreement of responses, of a method on frequency responses."""
    quantities: tuple[Quantity, ...] = ()
    """Corrected properties in their own units."""
    posterior: PosteriorSample | None = None
    """Samples of the posterior, if they were requested."""
    iterations: Mapping[str, int] = field(init=False)
    """Number of steps by stage, `location` and `updating`."""

    def __post_init__(self) -> None:
        stages = [iteration.stage for iteration in self.history]
        counts = {stage: stages.count(stage) for stage in ("location", "updating")}
        object.__setattr__(self, "iterations", counts)


TargetT = TypeVar("TargetT", contravariant=True)


class Updater(Protocol[TargetT]):
    """Updating method that corrects a model to a target, measured modes or measured frequency responses."""

    def __call__(
        self,
        structure: Structure,
        parameterisation: Parameterisation,
        target: TargetT,
        *,
        options: Any = ...,
        progress: Progress = silent,
    ) -> UpdateResult:
        """Return the updated model and how it was found."""
        ...


MASS_AND_STIFFNESS = (Part.MASS, Part.STIFFNESS)
MASS_STIFFNESS_AND_DAMPING = (Part.MASS, Part.STIFFNESS, Part.DAMPING)


@dataclass(frozen=True)
class UpdatingMethod(Generic[TargetT]):
    """An updating method with its options; called, it corrects a model."""

    update: Updater[TargetT]
    """Correction of a structure by measured modes or frequency responses."""
    options: type[UpdateOptions]
    """Options dataclass of the method."""
    parts: tuple[Part, ...] = MASS_AND_STIFFNESS
    """Parts of the members' matrices that are corrected where none are named."""

    @property
    def summary(self) -> str:
        """First line of the method's description."""
        return first_line(self.update)

    def __call__(
        self,
        structure: Structure,
        parameterisation: Parameterisation,
        target: TargetT,
        *,
        options: UpdateOptions | None = None,
        progress: Progress = silent,
    ) -> UpdateResult:
        """Return the updated model and how it was found; `InvalidInputError` of another method's options."""
        chosen = converted(options, self.options, "this method")
        return self.update(structure, parameterisation, target, options=chosen, progress=progress)


UPDATERS: Family[UpdatingMethod[ModalModel]] = Family("updating method", home="modallab.updating.methods")
