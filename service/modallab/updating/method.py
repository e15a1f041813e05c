"""What an updating method is, and what it returns."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from modallab.core.arrays import FloatArray, frozen
from modallab.core.modal_model import ModalModel
from modallab.core.options import converted
from modallab.core.progress import Progress, silent
from modallab.core.registry import Family, first_line
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
        options: Any = ...,
        progress: Progress = silent,
    ) -> UpdateResult:
        """Return the updated model and how it was found."""
        ...


MASS_AND_STIFFNESS = (Part.MASS, Part.STIFFNESS)
MASS_STIFFNESS_AND_DAMPING = (Part.MASS, Part.STIFFNESS, Part.DAMPING)


@dataclass(frozen=True)
class ModalUpdatingMethod:
    """An updating method on modes with its options; called, it corrects a model."""

    update: Updater
    """Correction of a structure by measured modes."""
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
        target: ModalModel,
        *,
        options: UpdateOptions | None = None,
        progress: Progress = silent,
    ) -> UpdateResult:
        """Return the updated model and how it was found; `InvalidInputError` of another method's options."""
        chosen = converted(options, self.options, "this method")
        return self.update(structure, parameterisation, target, options=chosen, progress=progress)


UPDATERS: Family[ModalUpdatingMethod] = Family("updating method", home="modallab.updating.methods")
