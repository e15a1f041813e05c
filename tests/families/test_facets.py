"""What every plate element must be: symmetric, passive, free to move as a rigid body, of the right mass."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.arrays import FloatArray
from modallab.fe.facet import FACETS, RIMS, Facets, plate_matrices, shell_matrices

SHAPES = {
    "triangle": np.array([[0.0, 0.0], [1.0, 0.1], [0.2, 0.8]]),
    "quadrilateral": np.array([[0.0, 0.0], [1.0, -0.1], [0.9, 0.8], [0.1, 0.6]]),
}


@st.composite
def facets(draw: st.DrawFn, kind: str) -> Facets:
    corners = draw(st.floats(0.01, 2.0)) * SHAPES[kind]
    if draw(st.booleans()):
        corners = corners[::-1]  # round the other way
    numbers = {
        "thickness": st.floats(1e-4, 0.05),
        "modulus": st.floats(1e9, 4e11),
        "density": st.floats(500.0, 2e4),
        "poisson_ratio": st.floats(0.0, 0.45),
    }
    return Facets(corners[None], **{name: np.array([draw(values)]) for name, values in numbers.items()})


def area_of(corners: FloatArray) -> float:
    x, y = corners.T
    return float(abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2)


def rigid_motions(corners: FloatArray) -> FloatArray:
    """(6 k, 6): along and about each axis, DoFs (u, v, w, theta_x, theta_y, theta_z) at each corner."""
    out = np.zeros((len(corners), 6, 6))
    for node, (x, y) in zip(out, corners, strict=True):
        node[:3, :3] = np.eye(3)
        node[3:, 3:] = np.eye(3)
        node[2, 3], node[2, 4] = y, -x
        node[0, 5], node[1, 5] = -y, x
    return out.reshape(-1, 6)


def test_every_element_has_the_rim_it_is_found_by() -> None:
    assert sorted(FACETS) == sorted(RIMS.values()) == sorted(SHAPES)


@pytest.mark.parametrize("kind", SHAPES)
@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_parts_are_symmetric_and_only_rigid_motions_strain_nothing(kind: str, data: st.DataObject) -> None:
    one = data.draw(facets(kind))
    mass, axial, bending = (part[0] for part in shell_matrices(one))
    k = one.corners.shape[1]
    across = np.add.outer(6 * np.arange(k), [2, 3, 4]).ravel()
    along = np.add.outer(6 * np.arange(k), [0, 1, 5]).ravel()
    for matrix, own in ((axial, along), (bending, across)):
        np.testing.assert_allclose(matrix, matrix.T, rtol=1e-12, atol=1e-14 * np.abs(matrix).max())
        # rotations are measured in lengths of the element, so that all numbers are of one kind
        scale = np.tile([1, 1, 1, *[1 / np.sqrt(area_of(one.corners[0]))] * 3], k)
        sized = (scale[:, None] * matrix * scale)[np.ix_(own, own)]
        values = np.linalg.eigvalsh(sized)
        # rounding of an exact zero; a thin plate bends 1e-5 times as easily as it shears
        assert np.abs(values[:3]).max() < 1e-12 * values[-1]
        assert values[3] > 1e-10 * values[-1]
    assert np.linalg.eigvalsh(mass)[0] > 0


@pytest.mark.parametrize("kind", SHAPES)
@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_rigid_motions_strain_nothing_and_carry_the_mass(kind: str, data: st.DataObject) -> None:
    one = data.draw(facets(kind))
    mass, axial, bending = (part[0] for part in shell_matrices(one))
    motions = rigid_motions(one.corners[0])
    for matrix in (axial, bending):
        # terms of this size cancel
        assert (np.abs(matrix @ motions) <= 1e-11 * np.abs(matrix) @ np.abs(motions)).all()
    total = float(one.density[0] * one.thickness[0]) * area_of(one.corners[0])
    # exact but for rounding: the shape functions add up to 1
    np.testing.assert_allclose(np.diag(motions.T @ mass @ motions)[:3], total, rtol=1e-12)


@pytest.mark.parametrize("kind", SHAPES)
@settings(max_examples=10, deadline=None)
@given(data=st.data())
def test_a_plate_is_the_shell_across_its_plane(kind: str, data: st.DataObject) -> None:
    one = data.draw(facets(kind))
    mass, bending = plate_matrices(one)
    in_space, _, bent = shell_matrices(one)
    across = np.add.outer(6 * np.arange(one.corners.shape[1]), [2, 3, 4]).ravel()
    np.testing.assert_array_equal(mass, in_space[:, across[:, None], across])
    np.testing.assert_array_equal(bending, bent[:, across[:, None], across])


@pytest.mark.parametrize("kind", SHAPES)
def test_an_element_turned_round_its_rim_is_the_same_element(kind: str) -> None:
    corners = SHAPES[kind]
    k = len(corners)
    numbers = [np.array([value]) for value in (0.01, 7e10, 2700.0, 0.3)]
    mass, axial, bending = shell_matrices(Facets(corners[None], *numbers))
    turned = shell_matrices(Facets(np.roll(corners, -1, axis=0)[None], *numbers))
    back = np.add.outer(6 * np.roll(np.arange(k), 1), np.arange(6)).ravel()
    for ours, theirs in zip((mass, axial, bending), turned, strict=True):
        # sums over the same points in another order
        again = theirs[0][np.ix_(back, back)]
        np.testing.assert_allclose(again, ours[0], rtol=1e-9, atol=1e-12 * np.abs(again).max())


@pytest.mark.parametrize("kind", FACETS)
def test_matrices_are_made_of_the_thickness_and_its_cube(kind: str) -> None:
    def at(thickness: float) -> FloatArray:
        numbers = (np.array([value]) for value in (thickness, 2e11, 7800.0, 0.3))
        return np.array([part[0] for part in shell_matrices(Facets(SHAPES[kind][None], *numbers))])

    once, twice = at(0.05), at(0.1)
    cubic = (twice - 2 * once) / 6
    for found, expected in zip(at(0.15), 3 * (once - cubic) + 27 * cubic, strict=True):
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())
