"""What every element must be: symmetric, passive, free to move as a rigid body, of the right mass."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.fe.element import ELEMENTS, Bar

BARS = st.builds(
    Bar,
    length=st.floats(0.01, 5.0),
    area=st.floats(1e-5, 1e-2),
    second_moment=st.floats(1e-10, 1e-4),
    modulus=st.floats(1e9, 4e11),
    density=st.floats(500.0, 2e4),
    shear_modulus=st.floats(4e8, 2e11),
    shear_coefficient=st.floats(0.1, 1.0),
)


def rigid_motions(length: float) -> np.ndarray:
    """(6, 3): along, across and turning about the first end, DoFs (u, v, theta) at each end."""
    return np.array(
        [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0], [1.0, 0, 0], [0, 1.0, length], [0, 0, 1.0]],
    )


@pytest.mark.parametrize("kind", ELEMENTS)
@settings(max_examples=25, deadline=None)
@given(bar=BARS)
def test_an_elements_parts_are_symmetric_and_never_negative(kind: str, bar: Bar) -> None:
    parts = ELEMENTS[kind](bar)
    for matrix in (parts.mass, *parts.stiffness.values()):
        np.testing.assert_array_equal(matrix, matrix.T)
        values = np.linalg.eigvalsh(matrix)
        assert values[0] >= -1e-12 * values[-1]  # rounding of an exact zero


@pytest.mark.parametrize("kind", ELEMENTS)
@settings(max_examples=25, deadline=None)
@given(bar=BARS)
def test_a_rigid_motion_strains_nothing(kind: str, bar: Bar) -> None:
    motions = rigid_motions(bar.length)
    for matrix in ELEMENTS[kind](bar).stiffness.values():
        force = np.abs(matrix @ motions)
        # terms of this size cancel
        assert (force <= 1e-12 * np.abs(matrix) @ np.abs(motions)).all()


@pytest.mark.parametrize("kind", ELEMENTS)
@settings(max_examples=25, deadline=None)
@given(bar=BARS)
def test_a_rigid_motion_carries_the_members_mass(kind: str, bar: Bar) -> None:
    mass = bar.density * bar.area * bar.length
    along, across, turning = rigid_motions(bar.length).T
    matrix = ELEMENTS[kind](bar).mass
    assert along @ matrix @ along == pytest.approx(mass, rel=1e-12)
    assert across @ matrix @ across == pytest.approx(mass, rel=1e-12)
    # a bar's moment of inertia about its end, without or with that of its sections: exact but for rounding
    thin, sections = mass * bar.length**2 / 3, bar.density * bar.second_moment * bar.length
    assert turning @ matrix @ turning in (
        pytest.approx(thin, rel=1e-9),
        pytest.approx(thin + sections, rel=1e-9),
    )


@pytest.mark.parametrize("kind", ELEMENTS)
def test_an_element_that_does_not_shear_bends_and_stretches_by_parts_of_their_own(kind: str) -> None:
    thin, thick = (Bar(1.0, area, 1e-8, 2e11, 7800.0) for area in (1e-4, 2e-4))
    before, after = ELEMENTS[kind](thin).stiffness, ELEMENTS[kind](thick).stiffness
    np.testing.assert_allclose(after["axial"], 2 * before["axial"], rtol=1e-12)
    np.testing.assert_allclose(after["bending"], before["bending"], rtol=1e-12)
    stiffer = ELEMENTS[kind](Bar(1.0, 1e-4, 2e-8, 2e11, 7800.0)).stiffness
    np.testing.assert_allclose(stiffer["bending"], 2 * before["bending"], rtol=1e-12)


@pytest.mark.parametrize("kind", ELEMENTS)
@pytest.mark.parametrize("size", ["area", "second_moment"])
def test_an_element_of_a_complex_size_says_how_it_moves_with_it(kind: str, size: str) -> None:
    bar, step = Bar(0.4, 1e-3, 1e-7, 2e11, 7800.0, 8e10), 1e-3
    by: dict[str, Any] = {size: getattr(bar, size)}
    aside, ahead, behind = (
        ELEMENTS[kind](replace(bar, **{size: factor * by[size]}))
        for factor in (1 + 1e-30j, 1 + step, 1 - step)
    )
    for one, more, less in (
        (aside.mass, ahead.mass, behind.mass),
        *((aside.stiffness[k], ahead.stiffness[k], behind.stiffness[k]) for k in ("axial", "bending")),
    ):
        moved = (more - less) / (2 * step)
        # central differences: 1e-6 of third derivatives, which are no larger than the matrix
        np.testing.assert_allclose(one.imag / 1e-30, moved, rtol=0, atol=1e-6 * np.abs(more).max())


@pytest.mark.parametrize("kind", ELEMENTS)
def test_an_element_says_what_it_is(kind: str) -> None:
    assert (ELEMENTS[kind].__doc__ or "").strip()
