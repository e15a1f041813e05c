"""Marks on fields of results: undetermined numbers, short arrays, fields left out where they are empty."""

from dataclasses import dataclass
from typing import Annotated

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray


@dataclass(frozen=True)
class Axes:
    """Mark of an array that is short enough to be read as a list, with its number of axes."""

    count: int


@dataclass(frozen=True)
class MayBeNan:
    """Mark of a number that is nan where the test does not determine it."""


@dataclass(frozen=True)
class LeftOutIfEmpty:
    """Mark of a sequence that most results do not have: a reply leaves it out where it is empty."""


NanFloat = Annotated[float, MayBeNan()]
Vector = Annotated[FloatArray, Axes(1)]
Matrix = Annotated[FloatArray, Axes(2)]
IntVector = Annotated[IntArray, Axes(1)]
BoolVector = Annotated[BoolArray, Axes(1)]
ComplexVector = Annotated[ComplexArray, Axes(1)]
