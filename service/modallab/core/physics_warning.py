"""Warnings of what is surely a slip: of a unit, or of a setting that makes a test say nothing."""

from dataclasses import dataclass


@dataclass(frozen=True)
class PhysicsWarning:
    """What is surely a slip of a unit or a setting, although it can be computed with."""

    code: str
    """Name of the rule."""
    message: str
    """What is unusual and what it suggests, for readers."""
    field: str
    """Field of the request that is probably wrong."""
