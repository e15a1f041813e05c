"""Degrees of freedom are written `node:direction`."""

import pytest
from hypothesis import given

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from tests.strategies import dofs


@given(dof=dofs)
def test_what_is_written_is_read_back(dof: Dof) -> None:
    assert Dof.parse(str(dof)) == dof


def test_a_sense_may_be_left_out_and_is_positive() -> None:
    assert Dof.parse(" 5:Y ") == Dof(5, "Y", 1)


@given(dof=dofs)
def test_a_point_has_no_sense_but_the_positive_one(dof: Dof) -> None:
    assert dof.point == Dof(dof.node, dof.direction, 1)
    assert dof.translational == (len(dof.direction) == 1)


@pytest.mark.parametrize("text", ["", "5", "5:", ":Y", "5:Q", "-5:Y", "5:++Y", "5:RW", "5:Y:Z", "5.5:Y"])
def test_what_is_no_dof_is_refused_with_an_example(text: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        Dof.parse(text, field="drive")
    assert caught.value.context["field"] == "drive"
    assert "5:+Y" in str(caught.value.context["allowed"])
