"""Bars and plates in space: closed forms, and that no axis is another."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import eigh, eigvalsh

from modallab.core.arrays import FloatArray
from modallab.fe.spatial import SpatialBars, SpatialPlates, bars_in_space, plates_in_space, warp

E, NU, RHO = 7e10, 0.3, 2700.0
G = E / 2 / (1 + NU)
AREA, FLAT, HIGH, TORSION = 4e-4, 3e-9, 4.8e-8, 1e-8
LENGTH = 1.2


def skew() -> FloatArray:
    """Axes that lie along no other."""
    turned, _ = np.linalg.qr(np.array([[1.0, 2.0, -0.5], [0.3, 1.0, 0.7], [-0.4, 0.2, 1.0]]))
    return np.asarray(turned * np.sign(np.linalg.det(turned)))


def row_of_bars(n: int, axes: FloatArray, shear: float = 0.0) -> SpatialBars:
    def each(value: float) -> FloatArray:
        return np.full(n, value)

    return SpatialBars(
        along=np.tile(LENGTH / n * axes[0], (n, 1)),
        upright=np.tile(axes[1] + 0.3 * axes[0], (n, 1)),
        modulus=each(E),
        shear_modulus=each(G),
        area=each(AREA),
        second_moments=np.tile([HIGH, FLAT], (n, 1)),
        torsion=each(TORSION),
        line_mass=each(RHO * AREA),
        polar_mass=each(RHO * (HIGH + FLAT)),
        shear_coefficients=np.full((n, 2), shear),
    )


def in_line(parts: FloatArray) -> FloatArray:
    n = len(parts)
    out = np.zeros((6 * (n + 1),) * 2)
    for i, part in enumerate(parts):
        out[6 * i : 6 * i + 12, 6 * i : 6 * i + 12] += part
    return out


def clamped_frequencies(axes: FloatArray) -> FloatArray:
    mass, axial, bending = (in_line(part) for part in bars_in_space(row_of_bars(24, axes)))
    return np.asarray(np.sqrt(eigvalsh((axial + bending)[6:, 6:], mass[6:, 6:])))


def test_a_clamped_bar_bends_both_ways_stretches_and_twists_as_in_closed_form() -> None:
    found = clamped_frequencies(np.eye(3))
    # Blevins (1979), tables 8-1 and 8-16: clamped and free
    bent = np.array([1.87510407, 4.69409113]) ** 2 / LENGTH**2 / np.sqrt(RHO * AREA)
    known = np.concatenate(
        [
            bent * np.sqrt(E * HIGH),
            bent * np.sqrt(E * FLAT),
            [np.pi / 2 / LENGTH * np.sqrt(E / RHO)],
            [np.pi / 2 / LENGTH * np.sqrt(G * TORSION / (RHO * (HIGH + FLAT)))],
        ]
    )
    for frequency in known:
        # linear shapes along the bar: (pi / 2 / 24)^2 / 24
        assert np.abs(found / frequency - 1).min() < 2e-4


def test_turned_as_a_whole_it_keeps_its_frequencies() -> None:
    straight, turned = clamped_frequencies(np.eye(3)), clamped_frequencies(skew())
    # rounding, times the highest eigenvalue over the lowest, 1e9
    np.testing.assert_allclose(turned[:20], straight[:20], rtol=1e-7)


@pytest.mark.parametrize("shear", [0.0, 0.83])
def test_a_bar_in_space_moves_without_force_in_six_ways_and_carries_its_mass(shear: float) -> None:
    axes = skew()
    mass, axial, bending = (part[0] for part in bars_in_space(row_of_bars(1, axes, shear)))
    rigid = np.zeros((12, 6))
    for end, place in enumerate((np.zeros(3), LENGTH * axes[0])):
        rigid[6 * end : 6 * end + 3, :3] = np.eye(3)
        rigid[6 * end + 3 : 6 * end + 6, 3:] = np.eye(3)
        rigid[6 * end : 6 * end + 3, 3:] = np.cross(np.eye(3), place).T @ np.eye(3)
    for stiffness in (axial, bending):
        # terms of this size cancel
        assert (np.abs(stiffness @ rigid) <= 1e-11 * np.abs(stiffness).max()).all()
    np.testing.assert_allclose((rigid.T @ mass @ rigid)[:3, :3], RHO * AREA * LENGTH * np.eye(3), atol=1e-12)
    assert np.linalg.matrix_rank(axial + bending, tol=1e-9 * np.abs(axial).max()) == 6


def test_a_vector_along_the_bar_turns_it_no_way() -> None:
    bars = row_of_bars(1, np.eye(3))
    bars.upright[:] = bars.along
    assert not np.isfinite(bars_in_space(bars)[0]).all()


def test_a_plate_in_space_is_the_flat_one_turned() -> None:
    rim = np.array([[0.0, 0.0, 0.0], [0.2, 0.01, 0.0], [0.22, 0.15, 0.0], [0.01, 0.14, 0.0]])
    numbers = [np.array([value]) for value in (0.003, E, RHO, NU)]
    flat = plates_in_space(SpatialPlates(rim[None], *numbers))
    turned = plates_in_space(SpatialPlates((rim @ skew().T)[None] + 0.7, *numbers))
    for ours, theirs in zip(flat, turned, strict=True):
        # the same energies: a matrix turned has the same eigenvalues
        one, other = np.linalg.eigvalsh(ours[0]), np.linalg.eigvalsh(theirs[0])
        np.testing.assert_allclose(other, one, atol=1e-12 * np.abs(one).max())


def test_a_strip_of_plates_stretches_and_twists_as_a_solid_body() -> None:
    """Six rigid motions, and the first lengthwise frequency of a free strip."""
    n, length, width = 30, 1.0, 0.05
    x = np.linspace(0, length, n + 1)
    rims = np.array([[[a, 0, 0], [b, 0, 0], [b, width, 0], [a, width, 0]] for a, b in pairwise(x)])
    own = [np.full(n, value) for value in (0.004, E, RHO, NU)]
    mass, axial, bending = np.zeros((3, 12 * (n + 1), 12 * (n + 1)))
    for e, parts in enumerate(zip(*plates_in_space(SpatialPlates(rims @ skew().T, *own)), strict=True)):
        rows = np.concatenate(
            [6 * corner + np.arange(6) for corner in (2 * e, 2 * e + 2, 2 * e + 3, 2 * e + 1)]
        )
        for total, part in zip((mass, axial, bending), parts, strict=True):
            total[np.ix_(rows, rows)] += part
    squares, shapes = eigh(axial + bending, mass)
    assert np.abs(squares[:6]).max() < 1e-6 * squares[6]  # rounding of zeros
    along = skew() @ np.array([1.0, 0.0, 0.0])
    moved = shapes.reshape(2 * (n + 1), 6, -1)[:, :3].transpose(0, 2, 1) @ along
    share = (moved**2).sum(axis=0) * RHO * 0.004 * width * length / (2 * (n + 1))
    lengthwise = int(np.argmax(share[6:] > 0.5)) + 6
    # thin bar: pi / L sqrt(E / rho); its width takes (nu pi width / L)^2 / 24
    exact = np.pi / length * np.sqrt(E / RHO)
    assert np.sqrt(squares[lengthwise]) == pytest.approx(exact, rel=2e-3)


def test_a_corner_off_the_plane_is_told() -> None:
    rim = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0.04], [0, 1, 0]])
    assert warp(rim[None])[0] == pytest.approx(0.01 / np.sqrt(2), rel=0.01)
