"""Marks on fields of results: numbers that may be undetermined, arrays short enough for a list."""

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


NanFloat = Annotated[float, MayBeNan()]
Vector = Annotated[FloatArray, Axes(1)]
Matrix = Annotated[FloatArray, Axes(2)]
IntVector = Annotated[IntArray, Axes(1)]
BoolVector = Annotated[BoolArray, Axes(1)]
ComplexVector = Annotated[ComplexArray, Axes(1)]
