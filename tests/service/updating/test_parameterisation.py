"""Which coefficients may move."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import coefficients_of
from modallab.fe.catalogued import STRUCTURES
from modallab.updating.parameterisation import (
    MacroElement,
    Parameterisation,
    Part,
    by_member,
    member_coefficients,
    parameterise,
)

BEAM = STRUCTURES["chapter-5-beam"]()


def test_every_part_of_every_group_has_a_coefficient() -> None:
    parameters = parameterise([(1, 2), (3,)], ("mass", "axial", "bending"))
    assert parameters.parts == (Part.MASS, Part.AXIAL, Part.BENDING)
    assert [str(macro) for macro in parameters.macros[:2]] == ["mass of 1, 2", "mass of 3"]
    assert len(parameters.macros) == 6


def test_a_coefficient_multiplies_what_its_members_carry() -> None:
    parameters = parameterise([(1, 2), (3,)])
    heavier = replace(BEAM, members=(replace(BEAM.members[0], mass_factor=3.0), *BEAM.members[1:]))
    spread = member_coefficients(
        parameters, parameters.groups(heavier), np.array([2.0, 1.0, 1.0, 5.0]), coefficients_of(heavier)
    )
    assert spread.mass[:3].tolist() == [6.0, 2.0, 1.0]
    assert spread.axial[:3].tolist() == spread.bending[:3].tolist() == [1.0, 1.0, 5.0]


def test_values_by_member_are_1_where_no_coefficient_is() -> None:
    parameters = parameterise([(2, 3)], ("mass",))
    table = by_member(parameters, np.array([1.5]), parts=(Part.MASS, Part.AXIAL), members=(1, 2, 3))
    assert table == {"mass": {1: 1.0, 2: 1.5, 3: 1.5}, "axial": {1: 1.0, 2: 1.0, 3: 1.0}}


def test_a_coefficient_of_damping_is_added_to_the_loss_factor() -> None:
    parameters = parameterise([(1, 2), (3,)], ("stiffness", "damping"), lower=0.5, upper=4.0)
    values = np.array([2.0, 1.0, 0.1, -0.002])
    spread = member_coefficients(parameters, parameters.groups(BEAM), values, coefficients_of(BEAM))
    own = coefficients_of(BEAM).loss_factor[0]
    np.testing.assert_allclose(spread.loss_factor[:4], own + np.array([0.1, 0.1, -0.002, 0.0]))
    assert spread.axial[:3].tolist() == [2.0, 2.0, 1.0]
    assert parameters.nominal.tolist() == [1.0, 1.0, 0.0, 0.0]
    assert [bound.tolist() for bound in parameters.bounds] == [[0.5, 0.5, -1.0, -1.0], [4.0, 4.0, 2.0, 2.0]]
    table = by_member(parameters, values, parts=parameters.parts, members=(1, 4))
    assert table["damping"] == {1: 0.1, 2: 0.1, 3: -0.002, 4: 0.0}


MASS_1 = MacroElement((1,), Part.MASS)
WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "no macro element": (lambda: Parameterisation(()), "macros"),
    "an empty one": (lambda: parameterise([(1,), ()]), "macros"),
    "a member twice in a part": (lambda: parameterise([(1, 2), (2, 3)]), "macros"),
    "stiffness and a part of it": (lambda: parameterise([(1,)], ("stiffness", "bending")), "macros"),
    "an unknown part": (lambda: parameterise([(1,)], ("colour",)), "parts"),
    "an unknown member": (lambda: parameterise([(99,)]).groups(BEAM), "members"),
    "a lower bound above 1": (lambda: Parameterisation((MASS_1,), lower=1.5), "lower"),
    "an upper bound below 1": (lambda: Parameterisation((MASS_1,), upper=0.5), "upper"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_a_parameterisation_is_refused_by_field(case: str) -> None:
    make, field = WRONG[case]
    with pytest.raises(InvalidInputError) as caught:
        make()
    assert caught.value.context["field"] == field
