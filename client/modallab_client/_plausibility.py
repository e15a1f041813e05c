"""Warnings of the service on what was sent, as Python's own."""

import sys
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol, TypeVar

from modallab_client.errors import PlausibilityWarning

_HERE = str(Path(__file__).parent)


class Slip(Protocol):
    """What the service says of a slip."""

    @property
    def message(self) -> str:
        """What is unusual and what it suggests."""
        ...

    @property
    def field(self) -> str:
        """Field that is probably wrong."""
        ...


class _Warned(Protocol):
    @property
    def warnings(self) -> Sequence[Slip]: ...


WarnedT = TypeVar("WarnedT", bound=_Warned)


def warned(result: WarnedT) -> WarnedT:
    """Return a result after a warning for each slip that the service names in it."""
    for slip in result.warnings:
        warn_of(slip)
    return result


def warn_of(slip: Slip) -> None:
    """Warn of a slip, at the line outside of the client that sent it."""
    warnings.warn(f"{slip.field}: {slip.message}", PlausibilityWarning, stacklevel=_level_of_caller())


def _level_of_caller() -> int:
    """Return the level of the first frame outside of the client, counted from the caller's."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_HERE):
        level, frame = level + 1, frame.f_back
    return level
