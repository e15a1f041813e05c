"""Marks on fields of domain types: how a value stands in a reply.

A field of a frozen dataclass becomes a field of the same name in the reply, described by its attribute
docstring. Arrays are told in `/arrays` only, unless a mark says that they are small.
"""

from dataclasses import dataclass
from typing import Annotated

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray


@dataclass(frozen=True)
class Axes:
    """Mark of an array that is small enough for JSON, by its number of axes."""

    count: int


@dataclass(frozen=True)
class MayBeNan:
    """Mark of a number that is nan where the test does not determine it; null in JSON."""


@dataclass(frozen=True)
class NotInReply:
    """Mark of a field that replies do not have, with the reason."""

    why: str


NanFloat = Annotated[float, MayBeNan()]
Vector = Annotated[FloatArray, Axes(1)]
Matrix = Annotated[FloatArray, Axes(2)]
IntVector = Annotated[IntArray, Axes(1)]
BoolVector = Annotated[BoolArray, Axes(1)]
ComplexVector = Annotated[ComplexArray, Axes(1)]
