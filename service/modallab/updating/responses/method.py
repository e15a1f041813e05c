"""What an updating method is that takes frequency responses instead of modes."""

from typing import Protocol

from modallab.core.progress import Progress, silent
from modallab.core.registry import Family
from modallab.fe.structure import Structure
from modallab.updating.method import DEFAULTS, UpdateOptions, UpdateResult
from modallab.updating.parameterisation import Parameterisation
from modallab.updating.responses.target import TargetResponses


class ResponseUpdater(Protocol):
    """Corrects a model until its frequency responses are the measured ones."""

    def __call__(
        self,
        structure: Structure,
        parameterisation: Parameterisation,
        target: TargetResponses,
        *,
        options: UpdateOptions = DEFAULTS,
        progress: Progress = silent,
    ) -> UpdateResult:
        """Return the updated model and how it was found."""
        ...


RESPONSE_UPDATERS: Family[ResponseUpdater] = Family(
    "updating method", home="modallab.updating.responses.methods"
)
