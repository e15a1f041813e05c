"""Warnings of the service on what was sent, as Python's own."""

import sys
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol, TypeVar

from modallab_client._generated.models import PhysicsWarning
from modallab_client.errors import PlausibilityWarning

_HERE = str(Path(__file__).parent)


class _Warned(Protocol):
    @property
    def warnings(self) -> Sequence[PhysicsWarning]: ...


WarnedT = TypeVar("WarnedT", bound=_Warned)


def warned(result: WarnedT) -> WarnedT:
    """Return a result after a warning for each slip that the service names in it."""
    for warning in result.warnings:
        words = f"{warning.field}: {warning.message}"
        warnings.warn(words, PlausibilityWarning, stacklevel=_level_of_caller())
    return result


def _level_of_caller() -> int:
    """Return the level of the first frame outside of the client, counted from the caller's."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_HERE):
        level, frame = level + 1, frame.f_back
    return level
