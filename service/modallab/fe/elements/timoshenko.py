"""Axial bar and Timoshenko beam in one element."""

import numpy as np

from modallab.fe.element import ELEMENTS, Bar, ElementParts
from modallab.fe.shear import BENDING_ROWS, bending_stiffness, rotary_inertia, sway_mass

AXIAL = np.ix_([0, 3], [0, 3])
BENDING = np.ix_(BENDING_ROWS, BENDING_ROWS)


@ELEMENTS.register("timoshenko")
def timoshenko(bar: Bar) -> ElementParts:
    """Return the (6, 6) parts of a frame element that shears and whose sections have inertia.

    DoFs (u, v, theta) at each end, theta the turn of the cross-section. Shear flexibility
    phi = 12 E I / (kappa A G L^2); consistent mass with rotary inertia rho I. Units: N/m, N, N m;
    kg, kg m, kg m^2. Przemieniecki (1968), section 5.6; Friedman and Kosmatka, Computers and
    Structures 47 (1993) 473-481.
    """
    length, mass = bar.length, bar.density * bar.area * bar.length
    k_axial, k_bending, m = bar.blank()
    k_axial[AXIAL] = bar.modulus * bar.area / length * np.array([[1, -1], [-1, 1]])
    m[AXIAL] = mass / 6 * np.array([[2, 1], [1, 2]])
    along, phi = np.array(length), np.array(bar.shear_flexibility)
    k_bending[BENDING] = bar.modulus * bar.second_moment * bending_stiffness(along, phi)
    m[BENDING] = bar.density * bar.area * sway_mass(along, phi)
    m[BENDING] += bar.density * bar.second_moment * rotary_inertia(along, phi)
    return ElementParts(mass=m, stiffness={"axial": k_axial, "bending": k_bending})
