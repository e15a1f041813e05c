"""A three-node plate that shears, on a membrane."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.fe.facet import (
    FACETS,
    SHEARED,
    FacetParts,
    Facets,
    bending_strains,
    drilling_strain,
    energy,
    membrane_strains,
    natural_shear,
    symmetric,
)

SLOPES = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])  # of the shape functions by r and s
POINTS = [(1 / 6, 1 / 6), (2 / 3, 1 / 6), (1 / 6, 2 / 3)]  # of weight 1/6 each: exact for squares


def _shapes(r: float, s: float) -> FloatArray:
    return np.array([1 - r - s, r, s])


def _tied(tangents: FloatArray, r: float, s: float) -> FloatArray:
    """Return the shear along r and s, (n, 2, 9), constant along each side; tangents are (n, 2, 2)."""

    def at(r: float, s: float, axis: int) -> FloatArray:
        return natural_shear(_shapes(r, s), SLOPES[axis], tangents[:, axis])

    along, across = at(0.5, 0.0, 0), at(0.0, 0.5, 1)
    slant = across - along - at(0.5, 0.5, 1) + at(0.5, 0.5, 0)
    return np.stack([along + slant * s, across - slant * r], axis=1)


@FACETS.register("triangle")
def triangle(facets: Facets) -> FacetParts:
    """Return the parts of linear Mindlin plates whose shear is tied along the sides.

    Lee and Bathe, Computers and Structures 82 (2004) 945-962 (MITC3). Constant strain in the membrane.
    Stiffer than quadrilaterals of the same size.
    """
    n, thickness = len(facets.corners), facets.thickness
    law, sheared = facets.plane_stress, SHEARED * facets.shear_modulus * thickness
    jacobian = SLOPES @ facets.corners  # (n, 2, 2)
    inverse = np.linalg.inv(jacobian)
    area = np.abs(np.linalg.det(jacobian)) / 2
    local = inverse @ SLOPES
    bending, drilling = np.zeros((2, n, 9, 9))
    bending += energy(bending_strains(local), law, area * thickness**3 / 12)
    eye = np.eye(2)[None]
    for place in POINTS:
        bending += energy(inverse @ _tied(jacobian, *place), eye, area * sheared / 3)
        turned = drilling_strain(_shapes(*place), local)
        drilling += energy(turned, eye[:, :1, :1], area * facets.shear_modulus * thickness / 3)
    overlap = area[:, None, None] / 12 * (np.ones((3, 3)) + np.eye(3))
    membrane = energy(membrane_strains(local), law, area * thickness)
    return FacetParts(overlap, symmetric(bending), symmetric(membrane), symmetric(drilling))
