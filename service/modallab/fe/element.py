"""Bar elements: a pure function of a bar that returns its element matrices by part."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.registry import Family
from modallab.fe.structure_settings import ELEMENT


@dataclass(frozen=True)
class Bar:
    """A straight member of constant section, in its own axes."""

    length: float  # m
    area: float  # m^2
    second_moment: float  # m^4
    modulus: float  # N/m^2
    density: float  # kg/m^3
    shear_modulus: float = float("inf")  # N/m^2; infinite: sections stay normal to the axis
    shear_coefficient: float = ELEMENT.shear_coefficient  # kappa, share of the area that shears

    def blank(self) -> FloatArray:
        """Return three empty matrices (6, 6), which hold complex numbers where the bar has one.

        A complex area or second moment gives a complex-step derivative: `section_size.size_derivatives`.
        """
        return np.zeros((3, 6, 6), np.result_type(self.area, self.second_moment))

    @property
    def shear_flexibility(self) -> float:
        """Phi = 12 E I / (kappa A G L^2): deflection from shear over that from bending."""
        sheared = self.shear_coefficient * self.area * self.shear_modulus * self.length**2
        return 12 * self.modulus * self.second_moment / sheared


@dataclass(frozen=True)
class ElementParts:
    """Matrices of one element in its own axes, each (6, 6): DoFs (u, v, theta) at each end.

    Every part can be corrected by a coefficient of its own.
    """

    mass: FloatArray  # kg, kg m, kg m^2
    stiffness: Mapping[str, FloatArray]  # "axial", "bending": N/m, N, N m


ELEMENTS: Family[Callable[[Bar], ElementParts]] = Family("element", home="modallab.fe.elements")
