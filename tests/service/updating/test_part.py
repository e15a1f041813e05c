"""What a coefficient may multiply, and what does not go together."""

import pytest

from modallab.core.errors import InvalidInputError
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.structure import Structure
from modallab.updating.parameterisation import parameterise
from modallab.updating.part import Part

BAY, PLATE = STRUCTURES["bay"](), STRUCTURES["plate"]()


@pytest.mark.parametrize(
    ("parts", "shared"),
    [
        (("modulus", "stiffness"), "axial"),
        (("bending", "modulus"), "bending"),
        (("density", "mass"), "mass"),
        (("area", "mass"), "mass"),
        (("axial", "area"), "axial"),
        (("second_moment", "stiffness"), "bending"),
        (("thickness", "mass"), "mass"),
        (("stiffness", "bending"), "bending"),
    ],
)
def test_a_property_and_a_matrix_that_it_moves_have_no_coefficient_both(
    parts: tuple[str, str], shared: str
) -> None:
    one, other = (part.replace("_", " ") for part in parts)
    with pytest.raises(InvalidInputError, match=f"{one} and of {other}, which both move its {shared} matrix"):
        parameterise([(1, 2), (3,)], parts)


@pytest.mark.parametrize("part", [part for part in Part if not part.is_nodal])
def test_a_member_has_one_coefficient_of_a_part(part: Part) -> None:
    with pytest.raises(InvalidInputError, match=f"member 2 has two coefficients of its {part.label}"):
        parameterise([(1, 2), (2, 3)], (part,))


@pytest.mark.parametrize(
    "parts",
    [
        ("density", "modulus", "area", "second_moment"),
        ("density", "modulus", "thickness"),
        ("density", "stiffness"),
        ("mass", "second_moment", "axial"),
        ("area", "bending", "damping"),
    ],
)
def test_properties_go_with_one_another_and_with_other_matrices(parts: tuple[str, ...]) -> None:
    assert len(parameterise([(1, 2), (3,)], parts).macros) == 2 * len(parts)


@pytest.mark.parametrize(
    ("structure", "part", "words"),
    [
        (BAY, "thickness", "member 1 is a bar, which has no thickness"),
        (PLATE, "second_moment", "member 1 is a plate, which has no second moment"),
        (PLATE, "area", "member 1 is a plate, which has no area"),
    ],
)
def test_a_property_that_a_member_does_not_have_is_refused(
    structure: Structure, part: str, words: str
) -> None:
    with pytest.raises(InvalidInputError, match=words) as caught:
        parameterise([(1,)], (part,)).groups(structure)
    assert caught.value.context["field"] == "parts"
