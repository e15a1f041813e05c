"""Axial bar and Bernoulli-Euler beam in one element."""

import numpy as np

from modallab.fe.element import ELEMENTS, Bar, ElementParts

AXIAL = np.ix_([0, 3], [0, 3])
BENDING = np.ix_([1, 2, 4, 5], [1, 2, 4, 5])


@ELEMENTS.register("frame")
def frame(bar: Bar) -> ElementParts:
    """Return the (6, 6) parts of a frame element, DoFs (u, v, theta) at each end.

    Axial and bending stiffness are separate parts, so that area and second moment of area
    can be corrected apart. Consistent mass. Units: N/m, N, N m; kg, kg m, kg m^2.
    1992 thesis, eq. [B.3], [B.6].
    """
    length, mass = bar.length, bar.density * bar.area * bar.length
    k_axial, k_bending, m = bar.blank()
    k_axial[AXIAL] = bar.modulus * bar.area / length * np.array([[1, -1], [-1, 1]])
    scale = np.array([1, length, 1, length])  # makes every entry below a plain number
    bend = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    k_bending[BENDING] = bar.modulus * bar.second_moment / length**3 * np.outer(scale, scale) * bend
    m[AXIAL] = mass / 6 * np.array([[2, 1], [1, 2]])
    sway = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
    m[BENDING] = mass / 420 * np.outer(scale, scale) * sway
    return ElementParts(mass=m, stiffness={"axial": k_axial, "bending": k_bending})
