"""Bars and plates in space: matrices in the axes of the structure."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.fe.facet import Facets, shell_matrices
from modallab.fe.shear import bending_stiffness, rotary_inertia, sway_mass
from modallab.fe.structure_settings import INPUT


@dataclass(frozen=True, eq=False)
class SpatialBars:
    """Straight bars of constant section; axes x along, y and z across, (n,) each but for the vectors."""

    along: FloatArray  # (n, 3) m, from first end to second
    upright: FloatArray  # (n, 3) with x it spans the plane of x and y
    modulus: FloatArray  # N/m^2
    shear_modulus: FloatArray  # N/m^2
    area: FloatArray  # m^2
    second_moments: FloatArray  # (n, 2) m^4: about z, of bending in the plane of x and y, and about y
    torsion: FloatArray  # m^4
    line_mass: FloatArray  # kg/m
    polar_mass: FloatArray  # kg m, moment of inertia about x, of a unit length
    shear_coefficients: FloatArray  # (n, 2) along y and z; 0: none shears


def bars_in_space(bars: SpatialBars) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return mass, axial and bending stiffness, (n, 12, 12) each; torsion goes with bending.

    DoFs X, Y, Z, RX, RY, RZ at each end. Bernoulli and Euler's beam, or Timoshenko's where it shears, with
    its consistent mass: Przemieniecki, Theory of Matrix Structural Analysis (1968), section 5.6.
    """
    n = len(bars.along)
    length = np.linalg.norm(bars.along, axis=1)
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    consistent = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6
    mass, axial, bending = np.zeros((3, n, 12, 12))

    def add(total: FloatArray, rows: list[int], part: FloatArray) -> None:
        total[:, np.array(rows)[:, None], rows] += part

    add(axial, [0, 6], (bars.modulus * bars.area / length)[:, None, None] * pair)
    add(bending, [3, 9], (bars.shear_modulus * bars.torsion / length)[:, None, None] * pair)
    add(mass, [0, 6], (bars.line_mass * length)[:, None, None] * consistent)
    add(mass, [3, 9], (bars.polar_mass * length)[:, None, None] * consistent)
    # theta_y = -w': rotations of the second plane count the other way
    for plane, plane_rows, sense in ((0, [1, 5, 7, 11], 1.0), (1, [2, 4, 8, 10], -1.0)):
        second, kappa = bars.second_moments[:, plane], bars.shear_coefficients[:, plane]
        rigidity = bars.modulus * second
        sheared = kappa * bars.area * bars.shear_modulus * length**2
        phi = np.divide(12 * rigidity, sheared, out=np.zeros(n), where=kappa > 0)
        signs = np.array([1.0, sense, 1.0, sense])
        sign_product = np.outer(signs, signs)
        add(bending, plane_rows, rigidity[:, None, None] * bending_stiffness(length, phi) * sign_product)
        transverse = bars.line_mass[:, None, None] * sway_mass(length, phi)
        # a bar without bending stiffness stays straight between its ends, whatever their rotations
        transverse[second == 0] = 0.0
        add(
            mass,
            plane_rows[::2],
            (np.where(second == 0, bars.line_mass, 0.0) * length)[:, None, None] * consistent,
        )
        inertia = np.divide(bars.line_mass * second, bars.area, out=np.zeros(n), where=kappa > 0)
        transverse += inertia[:, None, None] * rotary_inertia(length, phi)
        add(mass, plane_rows, transverse * sign_product)
    axes = bar_axes(bars)
    return _rotated(mass, axes), _rotated(axial, axes), _rotated(bending, axes)


def bar_axes(bars: SpatialBars) -> FloatArray:
    """Return the axes x, y, z of bars as rows, (n, 3, 3); not finite where the vector lies along the bar."""
    x = bars.along / np.linalg.norm(bars.along, axis=1)[:, None]
    z = np.cross(x, bars.upright)
    size = np.linalg.norm(z, axis=1)
    slanted = size > INPUT.min_orientation * np.linalg.norm(bars.upright, axis=1)
    z = z / np.where(slanted, size, np.nan)[:, None]
    return np.stack([x, np.cross(z, x), z], axis=1)


@dataclass(frozen=True, eq=False)
class SpatialPlates:
    """Flat plates of one number of corners, (n,) each but for the corners."""

    corners: FloatArray  # (n, k, 3) m
    thickness: FloatArray  # m
    modulus: FloatArray  # N/m^2
    density: FloatArray  # kg/m^3
    poisson_ratio: FloatArray


def plates_in_space(plates: SpatialPlates) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return mass, membrane and bending stiffness, (n, 6 k, 6 k) each, DoFs X to RZ at each corner."""
    axes = plate_axes(plates.corners)
    middle = plates.corners.mean(axis=1, keepdims=True)
    flat = (plates.corners - middle) @ axes.swapaxes(1, 2)
    facets = Facets(flat[:, :, :2], plates.thickness, plates.modulus, plates.density, plates.poisson_ratio)
    mass, axial, bending = shell_matrices(facets)
    return _rotated(mass, axes), _rotated(axial, axes), _rotated(bending, axes)


def plate_axes(corners: FloatArray) -> FloatArray:
    """Return axes of plates as rows, (n, 3, 3): x along the first side, z across."""
    k = corners.shape[1]
    first_edge = corners[:, 2] - corners[:, 0]
    second_edge = corners[:, 3] - corners[:, 1] if k == 4 else corners[:, 2] - corners[:, 1]
    z = np.cross(first_edge, second_edge)
    z = z / np.linalg.norm(z, axis=1)[:, None]
    side = corners[:, 1] - corners[:, 0]
    x = side - (side * z).sum(axis=1)[:, None] * z
    x = x / np.linalg.norm(x, axis=1)[:, None]
    return np.stack([x, np.cross(z, x), z], axis=1)


def warp(corners: FloatArray) -> FloatArray:
    """Return the distance of corners (n, k, 3) from their mean plane over the plate's size, (n,)."""
    z = plate_axes(corners)[:, 2]
    off = ((corners - corners.mean(axis=1, keepdims=True)) * z[:, None, :]).sum(axis=2)
    return np.asarray(np.abs(off).max(axis=1) / np.linalg.norm(corners[:, 2] - corners[:, 0], axis=1))


def convex(corners: FloatArray) -> BoolArray:
    """Return which corners (n, k, 3) go round a convex shape of some area, one way or the other, (n,)."""
    sides = np.roll(corners, -1, axis=1) - corners
    corner_normals = np.cross(np.roll(sides, 1, axis=1), sides)  # (n, k, 3): area and normal at each corner
    normal = corner_normals.sum(axis=1)
    size = (sides**2).sum(axis=2).max(axis=1)
    return np.asarray(
        (
            (corner_normals * normal[:, None, :]).sum(axis=2)
            > INPUT.min_spatial_corner_area * size[:, None] ** 2
        ).all(axis=1)
    )


def _rotated(matrices: FloatArray, axes: FloatArray) -> FloatArray:
    """Return matrices (n, m, m) of vectors, three numbers each, in the axes of the structure."""
    n, m = matrices.shape[:2]
    rotation = np.zeros((n, m, m))
    for first in range(0, m, 3):
        rotation[:, first : first + 3, first : first + 3] = axes
    return np.asarray(rotation.swapaxes(1, 2) @ matrices @ rotation)
