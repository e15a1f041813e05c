"""Place of an effect, and specification of an effect as plain data."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated

from modallab.core.dof import Dof
from modallab.core.reply import LeftOutIfEmpty


@dataclass(frozen=True)
class Members:
    """Members of a structure by number."""

    numbers: tuple[int, ...]

    def __str__(self) -> str:
        return "members " + ", ".join(map(str, self.numbers))


@dataclass(frozen=True)
class Dofs:
    """DoFs of a structure at which equal parts act."""

    dofs: tuple[Dof, ...]

    def __str__(self) -> str:
        return " and ".join(map(str, self.dofs))


@dataclass(frozen=True)
class Channels:
    """Response channels, named by the DoF each one measures."""

    dofs: tuple[Dof, ...]

    @cached_property
    def points(self) -> tuple[Dof, ...]:
        """Measured DoFs in their positive sense."""
        return tuple(dof.point for dof in self.dofs)

    def __str__(self) -> str:
        return "channels " + ", ".join(map(str, self.dofs))


Place = Dof | Dofs | Members | Channels | None  # None: everywhere
TableRow = tuple[float, float, float]
"""Frequency, Hz, real part and imaginary part of a tabulated curve."""


@dataclass(frozen=True)
class EffectSpec:
    """An effect as a log book or a request names it; `rig.effect.build` gives it its physics."""

    kind: str
    """Name of the effect in the catalogue."""
    at: Place = None
    """Place where the effect acts; None: everywhere."""
    parameters: Mapping[str, float] = field(default_factory=dict)
    """SI units, parameters of the effect by name."""
    table: Annotated[tuple[TableRow, ...], LeftOutIfEmpty()] = ()
    """Curve of a tabulated effect; empty: the default of the catalogue, or no tabulated effect."""
