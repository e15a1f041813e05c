"""Assumptions about a test that neither its file nor its log book states."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Assumption:
    """One assumption about an imported test."""

    quantity: str
    """Assumed quantity: averages, unit, window, exciter, points, variables, columns, ..."""
    value: str
    """Assumed value, in words."""
    reason: str
    """Reason for the assumption, and what to declare instead."""
