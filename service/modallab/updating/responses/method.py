"""Interface of updating methods on frequency responses."""

from dataclasses import dataclass
from typing import Any, Protocol

from modallab.core.options import converted
from modallab.core.progress import Progress, silent
from modallab.core.registry import Family, first_line
from modallab.fe.structure import Structure
from modallab.updating.method import MASS_STIFFNESS_AND_DAMPING, UpdateResult
from modallab.updating.options import ResponseUpdateOptions, UpdateOptions
from modallab.updating.parameterisation import Parameterisation, Part
from modallab.updating.responses.target import TargetResponses


class ResponseUpdater(Protocol):
    """Updating method that corrects a model to measured frequency responses."""

    def __call__(
        self,
        structure: Structure,
        parameterisation: Parameterisation,
        target: TargetResponses,
        *,
        options: Any = ...,
        progress: Progress = silent,
    ) -> UpdateResult:
        """Return the updated model and how it was found."""
        ...


@dataclass(frozen=True)
class ResponseUpdatingMethod:
    """An updating method on frequency responses with its options; called, it corrects a model."""

    update: ResponseUpdater
    """Correction of a structure by measured frequency responses."""
    options: type[ResponseUpdateOptions] = ResponseUpdateOptions
    """Options dataclass of the method."""
    parts: tuple[Part, ...] = MASS_STIFFNESS_AND_DAMPING
    """Parts of the members' matrices that are corrected where none are named."""

    @property
    def summary(self) -> str:
        """First line of the method's description."""
        return first_line(self.update)

    def __call__(
        self,
        structure: Structure,
        parameterisation: Parameterisation,
        target: TargetResponses,
        *,
        options: UpdateOptions | None = None,
        progress: Progress = silent,
    ) -> UpdateResult:
        """Return the updated model and how it was found; `InvalidInputError` of another method's options."""
        chosen = converted(options, self.options, "this method")
        return self.update(structure, parameterisation, target, options=chosen, progress=progress)


RESPONSE_UPDATERS: Family[ResponseUpdatingMethod] = Family(
    "updating method", home="modallab.updating.responses.methods"
)
