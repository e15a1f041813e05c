"""Sections and thicknesses: what member matrices do when these change."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.member_matrices import member_matrices
from modallab.fe.members import Member, Plate
from modallab.fe.section_size import SectionSize, resized, size, size_derivatives
from modallab.fe.structure import ACROSS, Material, Structure

BAY = STRUCTURES["bay"]()
STOCKY = replace(BAY, members=tuple(replace(m, element="timoshenko") for m in BAY.members))
STEEL = Material(2.09e11, 7800.0)
PLATES = Structure(
    nodes={1: (0.0, 0.0), 2: (0.3, 0.02), 3: (0.32, 0.25), 4: (-0.03, 0.2), 5: (0.5, 0.1)},
    members=(),
    non_bar_members=(Plate(1, (1, 2, 3, 4), 0.02, STEEL), Plate(2, (2, 5, 3), 0.02, STEEL)),
    directions=ACROSS,
)


def matrices(structure: Structure, shape: SectionSize, factor: float) -> FloatArray:
    """Return mass, axial and bending stiffness (3, n, w, w) with every size so many times what it is."""
    members = [resized(m, shape, factor * size(m, shape)) for m in structure.all_members]
    found = member_matrices(structure, members)
    return np.array([found.mass, found.axial, found.bending])


def ours(structure: Structure, shape: SectionSize) -> FloatArray:
    width = matrices(structure, shape, 1.0).shape[-1]
    return size_derivatives(structure, structure.all_members, shape, width)


def near(found: FloatArray, expected: FloatArray, rtol: float) -> None:
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=rtol * np.abs(other).max())


@pytest.mark.parametrize(
    ("shape", "powers"), [(SectionSize.AREA, (1, 1, 0)), (SectionSize.SECOND_MOMENT, (0, 0, 1))], ids=str
)
def test_a_slender_bar_goes_in_proportion(shape: SectionSize, powers: tuple[int, int, int]) -> None:
    now = matrices(BAY, shape, 1.0)
    expected = np.array([power * part for power, part in zip(powers, now, strict=True)])
    near(ours(BAY, shape), expected, 1e-14)
    near(matrices(BAY, shape, 3.0), now + 2 * expected, 1e-14)


@pytest.mark.parametrize("shape", [SectionSize.AREA, SectionSize.SECOND_MOMENT], ids=str)
def test_a_bar_that_shears_has_exact_slopes(shape: SectionSize) -> None:
    step = 1e-2
    two, one, back, far = (matrices(STOCKY, shape, float(np.exp(k * step))) for k in (2, 1, -1, -2))
    # differences of fourth order in the logarithm: 1e-8 / 30 of fifth derivatives, which for
    # a product of powers are as large as the matrix itself
    near(ours(STOCKY, shape), (8 * (one - back) - (two - far)) / (12 * step), 2e-9)


def test_a_plate_is_made_of_its_thickness_and_its_cube() -> None:
    now, slope = matrices(PLATES, SectionSize.THICKNESS, 1.0), ours(PLATES, SectionSize.THICKNESS)
    cubic = (slope - now) / 2  # of X = A + B with slope A + 3 B
    # the law itself, at another thickness than those that the slopes are taken from
    near(matrices(PLATES, SectionSize.THICKNESS, 5.0), 5 * (now - cubic) + 125 * cubic, 1e-13)
    mass, _, bending = np.abs(cubic).max(axis=(1, 2, 3))
    assert min(mass, bending) > 0
    stretched = np.abs(now - cubic)[2].max(axis=(1, 2))
    assert stretched[0] > 0.5 * np.abs(now[2, 0]).max(), "a thick quadrilateral shears"
    assert stretched[1] < 1e-13 * np.abs(now[2, 1]).max(), "a thin triangle does not"


def test_the_size_of_one_member_is_its_own() -> None:
    member = BAY.members[4]
    larger = resized(resized(member, SectionSize.AREA, 0.01), SectionSize.SECOND_MOMENT, 2e-5)
    assert isinstance(larger, Member)
    assert (larger.section.area, larger.section.second_moment) == (0.01, 2e-5)
    assert size(larger, SectionSize.AREA) == 0.01
    assert replace(larger, section=member.section) == member


@pytest.mark.parametrize(
    ("structure", "shape", "allowed"),
    [
        (PLATES, SectionSize.AREA, ["thickness"]),
        (PLATES, SectionSize.SECOND_MOMENT, ["thickness"]),
        (BAY, SectionSize.THICKNESS, ["area", "second_moment"]),
    ],
)
def test_a_size_that_a_member_does_not_have_is_refused(
    structure: Structure, shape: SectionSize, allowed: list[str]
) -> None:
    for refused in (
        lambda: size(structure.all_members[0], shape, field="parts"),
        lambda: resized(structure.all_members[0], shape, 1.0),
    ):
        with pytest.raises(InvalidInputError, match="has no") as caught:
            refused()
        assert caught.value.context["allowed"] == allowed
        assert caught.value.context["value"] == shape.value
