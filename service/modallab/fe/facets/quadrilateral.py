"""A four-node plate that shears, on a membrane."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.fe.facet import (
    FACETS,
    FacetParts,
    Facets,
    bending_strains,
    drilling_strain,
    membrane_strains,
    natural_shear,
    strain_energy,
    symmetric,
)
from modallab.fe.structure_settings import ELEMENT

XI, ETA = np.array([-1.0, 1.0, 1.0, -1.0]), np.array([-1.0, -1.0, 1.0, 1.0])  # of the corners
GAUSS = [(a / np.sqrt(3), b / np.sqrt(3)) for a in (-1, 1) for b in (-1, 1)]  # of weight 1 each


def _shapes(xi: float, eta: float) -> tuple[FloatArray, FloatArray]:
    """Return the shape functions (4,) and their derivatives by xi and eta (2, 4)."""
    along, across = 1 + XI * xi, 1 + ETA * eta
    return along * across / 4, np.array([XI * across, ETA * along]) / 4


def _assumed_shear_strain(corners: FloatArray, xi: float, eta: float) -> FloatArray:
    """Return assumed shear strains along xi and eta, (n, 2, 12), from the midpoints of opposite sides."""

    def at(place: tuple[float, float], axis: int) -> FloatArray:
        shapes, slopes = _shapes(*place)
        return natural_shear(shapes, slopes[axis], slopes[axis] @ corners)

    along = (1 - eta) / 2 * at((0.0, -1.0), 0) + (1 + eta) / 2 * at((0.0, 1.0), 0)
    across = (1 - xi) / 2 * at((-1.0, 0.0), 1) + (1 + xi) / 2 * at((1.0, 0.0), 1)
    return np.stack([along, across], axis=1)


@FACETS.register("quadrilateral")
def quadrilateral(facets: Facets) -> FacetParts:
    """Return the parts of bilinear Mindlin plates with assumed shear strains from the midpoints of the sides.

    The four points do not lock however thin the plate: Bathe and Dvorkin, International Journal for
    Numerical Methods in Engineering 21 (1985) 367-383 (MITC4). Bilinear membrane in plane stress.
    """
    n, corners, thickness = len(facets.corners), facets.corners, facets.thickness
    law, sheared = facets.plane_stress, ELEMENT.shear_coefficient * facets.shear_modulus * thickness
    overlap, membrane = np.zeros((n, 4, 4)), np.zeros((n, 8, 8))
    bending, drilling = np.zeros((2, n, 12, 12))
    eye = np.eye(2)[None]
    for place in GAUSS:
        shapes, slopes = _shapes(*place)
        jacobian = slopes @ corners  # (n, 2, 2)
        area = np.abs(np.linalg.det(jacobian))
        inverse = np.linalg.inv(jacobian)
        local = inverse @ slopes
        overlap += area[:, None, None] * np.outer(shapes, shapes)
        membrane += strain_energy(membrane_strains(local), law, area * thickness)
        bending += strain_energy(bending_strains(local), law, area * thickness**3 / 12)
        bending += strain_energy(inverse @ _assumed_shear_strain(corners, *place), eye, area * sheared)
        drilling += strain_energy(
            drilling_strain(shapes, local), eye[:, :1, :1], area * facets.shear_modulus * thickness
        )
    return FacetParts(overlap, symmetric(bending), symmetric(membrane), symmetric(drilling))
