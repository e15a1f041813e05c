"""A fitted number says unit, bounds and meaning once, and keeps to them."""

from dataclasses import dataclass

import pytest

from modallab.core.errors import InvalidInputError
from modallab.core.parameters import Parameterised, parameter


@dataclass(frozen=True)
class Ballast(Parameterised):
    """Something with a number that may be fitted."""

    node: int
    mass: float = parameter(0.1, unit="kg", lower=0.0, upper=2.0, doc="what hangs there")


def test_specifications_are_read_where_they_were_declared() -> None:
    spec = Ballast.specs()
    assert list(spec) == ["mass"]
    assert (spec["mass"].unit, spec["mass"].lower, spec["mass"].upper, spec["mass"].absent) == ("kg", 0, 2, 0)


@pytest.mark.parametrize("mass", [-0.1, 2.1, float("nan"), float("inf")])
def test_a_value_out_of_bounds_is_refused_with_them(mass: float) -> None:
    with pytest.raises(InvalidInputError) as caught:
        Ballast(1, mass)
    assert caught.value.context["field"] == "mass"
    assert caught.value.context["allowed"] == {"minimum": 0.0, "maximum": 2.0, "unit": "kg"}
