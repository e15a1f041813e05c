"""An option's default, unit, bounds and choices stand with its field, and are kept to."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import pytest

from modallab.core.errors import InvalidInputError
from modallab.core.options import Options, option


class Colour(StrEnum):
    """A closed set of names."""

    RED = "red"
    BLUE = "blue"


@dataclass(frozen=True)
class PaintOptions(Options):
    """How something is painted."""

    coats: int = option(2, unit="1", lower=1, upper=5, doc="coats of paint")
    thickness: float | None = option(None, unit="m", lower=0.0, doc="thickness of a coat")
    share: float = option(0.5, unit="1", exclusive_minimum=0.0, upper=1.0, doc="painted part of the surface")
    colour: Colour | None = option(Colour.RED, doc="colour of the last coat")
    finish: str = option("matt", doc="finish of the last coat", choices=("matt", "gloss"))
    dry: bool = option(True, doc="whether the coats dry between")


def test_specifications_are_read_where_they_are_declared() -> None:
    specs = PaintOptions.specs()
    assert list(specs) == ["coats", "thickness", "share", "colour", "finish", "dry"]
    coats = specs["coats"]
    assert (coats.default, coats.unit, coats.lower, coats.upper) == (2, "1", 1, 5)
    assert specs["colour"].choices == ("red", "blue")
    assert specs["colour"].default == "red"


REFUSED: list[tuple[str, Any, Any]] = [
    ("coats", 6, {"minimum": 1, "maximum": 5}),
    ("coats", 0, {"minimum": 1, "maximum": 5}),
    ("thickness", -1e-3, {"minimum": 0.0, "unit": "m"}),
    ("thickness", float("nan"), {"minimum": 0.0, "unit": "m"}),
    ("share", 0.0, {"exclusiveMinimum": 0.0, "maximum": 1.0}),
    ("colour", "green", ["red", "blue"]),
    ("finish", "rough", ["matt", "gloss"]),
]


@pytest.mark.parametrize(("name", "value", "allowed"), REFUSED)
def test_an_option_out_of_bounds_is_refused_with_them(name: str, value: Any, allowed: Any) -> None:
    with pytest.raises(InvalidInputError) as refused:
        PaintOptions(**{name: value})
    assert refused.value.context["field"] == name
    assert refused.value.context["allowed"] == allowed


def test_a_name_becomes_a_member_of_its_set() -> None:
    given: Any = "blue"
    assert PaintOptions(colour=given).colour is Colour.BLUE
    assert PaintOptions(colour=None, thickness=None).thickness is None
