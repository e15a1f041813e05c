"""Plate elements: vectorised functions of flat facets that return their element matrices."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.registry import Family


@dataclass(frozen=True, eq=False)
class Facets:
    """Flat elements of one number of corners, each of constant thickness, in their own plane."""

    corners: FloatArray  # (n, k, 2) m, round the rim, one way or the other
    thickness: FloatArray  # (n,) m
    modulus: FloatArray  # (n,) N/m^2
    density: FloatArray  # (n,) kg/m^3
    poisson_ratio: FloatArray  # (n,)

    @property
    def shear_modulus(self) -> FloatArray:
        """(n,) G = E / (2 (1 + nu)), N/m^2."""
        return self.modulus / (2 * (1 + self.poisson_ratio))

    @property
    def plane_stress(self) -> FloatArray:
        """(n, 3, 3) stress (xx, yy, xy) from strain, shear as an angle, N/m^2."""
        nu = self.poisson_ratio
        unit, zero = np.ones_like(nu), np.zeros_like(nu)
        rows = [[unit, nu, zero], [nu, unit, zero], [zero, zero, (1 - nu) / 2]]
        return np.asarray(np.moveaxis(np.array(rows), 2, 0) * (self.modulus / (1 - nu**2))[:, None, None])


@dataclass(frozen=True, eq=False)
class FacetParts:
    """Matrices of facets, node by node."""

    overlap: FloatArray  # (n, k, k) m^2, integral of N_i N_j
    bending: FloatArray  # (n, 3 k, 3 k) of (w, theta_x, theta_y): N/m, N, N m; transverse shear with it
    membrane: FloatArray  # (n, 2 k, 2 k) of (u, v), N/m
    drilling: FloatArray  # (n, 3 k, 3 k) of (u, v, theta_z): N/m, N, N m


FACETS: Family[Callable[[Facets], FacetParts]] = Family("facet", home="modallab.fe.facets")
"""Plate elements by the shape of their rim, one file each."""

RIMS = {3: "triangle", 4: "quadrilateral"}


def facet_parts(facets: Facets) -> FacetParts:
    """Return the matrices of facets, by the element of their number of corners."""
    return FACETS[RIMS[facets.corners.shape[1]]](facets)


def bending_strains(slopes: FloatArray) -> FloatArray:
    """Return curvatures (xx, yy, xy) of (w, theta_x, theta_y) at each node, (n, 3, 3 k).

    A point at height z moves by z theta_y along x and by -z theta_x along y.

    Parameters
    ----------
    slopes
        (n, 2, k) derivatives of the shape functions along x and y, 1/m.
    """
    along_x, along_y = slopes[:, 0], slopes[:, 1]
    out = np.zeros((len(slopes), 3, 3 * slopes.shape[2]))
    out[:, 0, 2::3] = along_x
    out[:, 1, 1::3] = -along_y
    out[:, 2, 2::3] = along_y
    out[:, 2, 1::3] = -along_x
    return out


def membrane_strains(slopes: FloatArray) -> FloatArray:
    """Return strains (xx, yy, xy) of (u, v) at each node, (n, 3, 2 k), from slopes (n, 2, k)."""
    out = np.zeros((len(slopes), 3, 2 * slopes.shape[2]))
    out[:, 0, 0::2] = slopes[:, 0]
    out[:, 1, 1::2] = slopes[:, 1]
    out[:, 2, 0::2] = slopes[:, 1]
    out[:, 2, 1::2] = slopes[:, 0]
    return out


def drilling_strain(shapes: FloatArray, slopes: FloatArray) -> FloatArray:
    """Return theta_z - (v,x - u,y) / 2 of (u, v, theta_z) at each node, (n, 1, 3 k).

    Its square times G t couples the drilling rotation to the rotation of the plane: Hughes and Brezzi,
    Computer Methods in Applied Mechanics and Engineering 72 (1989) 105-121.
    """
    out = np.zeros((len(slopes), 1, 3 * slopes.shape[2]))
    out[:, 0, 0::3] = slopes[:, 1] / 2
    out[:, 0, 1::3] = -slopes[:, 0] / 2
    out[:, 0, 2::3] = shapes
    return out


def natural_shear(shapes: FloatArray, slopes: FloatArray, tangent: FloatArray) -> FloatArray:
    """Return the transverse shear along a natural coordinate of (w, theta_x, theta_y), (n, 3 k).

    Parameters
    ----------
    shapes
        (k,) shape functions at the point.
    slopes
        (k,) their derivatives by the coordinate.
    tangent
        (n, 2) derivatives of x and y by the coordinate, m.
    """
    out = np.zeros((len(tangent), 3 * len(shapes)))
    out[:, 0::3] = slopes
    out[:, 1::3] = -tangent[:, 1:] * shapes
    out[:, 2::3] = tangent[:, :1] * shapes
    return out


def strain_energy(strains: FloatArray, elasticity: FloatArray, weight: FloatArray) -> FloatArray:
    """Return B^T C B times a weight (n,): strains (n, s, m), law (n, s, s)."""
    return np.asarray(strains.swapaxes(1, 2) @ (weight[:, None, None] * elasticity) @ strains)


def symmetric(matrices: FloatArray) -> FloatArray:
    """Return the symmetric part of matrices (n, m, m), which are symmetric but for rounding."""
    return np.asarray((matrices + matrices.swapaxes(1, 2)) / 2)


def plate_matrices(facets: Facets) -> tuple[FloatArray, FloatArray]:
    """Return mass and bending stiffness of motion across the plane, (n, 3 k, 3 k) each.

    DoFs (w, theta_x, theta_y) at each corner. Consistent mass with rotary inertia of the normals.
    """
    parts = facet_parts(facets)
    line = facets.density * facets.thickness
    rotary = line * facets.thickness**2 / 12
    return _mass_matrices(parts.overlap, np.stack([line, rotary, rotary], 1)), parts.bending


def shell_matrices(facets: Facets) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return mass, membrane and bending stiffness in space, (n, 6 k, 6 k) each.

    DoFs (u, v, w, theta_x, theta_y, theta_z) at each corner, in the facets' own axes; the stiffness of
    drilling goes with the membrane's.
    """
    parts = facet_parts(facets)
    n, k = facets.corners.shape[:2]
    line = facets.density * facets.thickness
    rotary = line * facets.thickness**2 / 12
    mass = _mass_matrices(parts.overlap, np.stack([line] * 3 + [rotary] * 3, 1))
    node = 6 * np.arange(k)[:, None]
    axial, bending = np.zeros((2, n, 6 * k, 6 * k))
    for total, part, directions in (
        (axial, parts.membrane, [0, 1]),
        (axial, parts.drilling, [0, 1, 5]),
        (bending, parts.bending, [2, 3, 4]),
    ):
        place = (node + directions).ravel()
        total[:, place[:, None], place] += part
    return mass, axial, bending


def _mass_matrices(overlap: FloatArray, inertia: FloatArray) -> FloatArray:
    """Return overlaps (n, k, k) as mass of DoFs with inertia (n, d) each, (n, d k, d k)."""
    n, k = overlap.shape[:2]
    d = inertia.shape[1]
    out = np.zeros((n, k, d, k, d))
    direction = np.arange(d)
    out[:, :, direction, :, direction] = np.einsum("nij,nd->dnij", overlap, inertia)
    return out.reshape(n, k * d, k * d)
