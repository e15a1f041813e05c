"""A three-node thin plate, on a membrane."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.fe.facet import (
    FACETS,
    FacetParts,
    Facets,
    drilling_strain,
    membrane_strains,
    strain_energy,
    symmetric,
)

SLOPES = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])  # of the linear shape functions by r and s
POINTS = [(1 / 6, 1 / 6), (2 / 3, 1 / 6), (1 / 6, 2 / 3)]  # of weight 1/3 of the area: exact for squares
SIDES = [(0, 1), (1, 2), (2, 0)]


def _shapes(r: float, s: float) -> FloatArray:
    return np.array([1 - r - s, r, s])


def _quadratic_slopes(r: float, s: float) -> FloatArray:
    """Return derivatives by r and s, (2, 6), of quadratic shapes: of corners, then middles of `SIDES`."""
    linear = _shapes(r, s)
    corners = (4 * linear - 1) * SLOPES
    middles = [4 * (linear[a] * SLOPES[:, b] + linear[b] * SLOPES[:, a]) for a, b in SIDES]
    return np.hstack([corners, np.array(middles).T])


def _turns(corners: FloatArray) -> FloatArray:
    """Return the rotations of the normals towards x and y, (n, 6, 2, 9), at corners and midpoints of sides.

    At the midpoints a normal is normal to a cubic along the side, and its rotation across is linear.
    """
    n = len(corners)
    out = np.zeros((n, 6, 2, 9))
    for i in range(3):
        out[:, i, 0, 3 * i + 2] = 1.0  # beta_x = theta_y
        out[:, i, 1, 3 * i + 1] = -1.0  # beta_y = -theta_x
    for k, (a, b) in enumerate(SIDES, 3):
        side = corners[:, b] - corners[:, a]
        length = np.linalg.norm(side, axis=1)[:, None]
        tangent = side / length
        mixed = np.eye(2) / 2 - 0.75 * tangent[:, :, None] * tangent[:, None, :]
        out[:, k] = mixed @ (out[:, a] + out[:, b])
        out[:, k, :, 3 * a] += 1.5 * tangent / length
        out[:, k, :, 3 * b] -= 1.5 * tangent / length
    return out


@FACETS.register("triangle")
def triangle(facets: Facets) -> FacetParts:
    """Return the parts of discrete Kirchhoff triangles: thin plates without transverse shear.

    Batoz, Bathe and Ho, International Journal for Numerical Methods in Engineering 15 (1980) 1771-1812
    (DKT). Constant strain in the membrane; the deflection that carries mass is linear.
    """
    n, thickness = len(facets.corners), facets.thickness
    law = facets.plane_stress
    jacobian = SLOPES @ facets.corners  # (n, 2, 2)
    inverse = np.linalg.inv(jacobian)
    area = np.abs(np.linalg.det(jacobian)) / 2
    local = inverse @ SLOPES
    bending, drilling = np.zeros((2, n, 9, 9))
    turns = _turns(facets.corners)
    eye = np.eye(1)[None]
    for place in POINTS:
        slopes = inverse @ _quadratic_slopes(*place)  # (n, 2, 6)
        bent = np.einsum("nai,nibm->nabm", slopes, turns)  # of beta_b along a
        curvature = np.stack([bent[:, 0, 0], bent[:, 1, 1], bent[:, 1, 0] + bent[:, 0, 1]], axis=1)
        bending += strain_energy(curvature, law, area * thickness**3 / 36)
        turned = drilling_strain(_shapes(*place), local)
        drilling += strain_energy(turned, eye, area * facets.shear_modulus * thickness / 3)
    overlap = area[:, None, None] / 12 * (np.ones((3, 3)) + np.eye(3))
    membrane = strain_energy(membrane_strains(local), law, area * thickness)
    return FacetParts(overlap, symmetric(bending), symmetric(membrane), symmetric(drilling))
