"""Stinger as declared: a rod between armature and force gauge."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import FloatArray
from modallab.core.dof import TRANSLATIONS, Dof
from modallab.fe.system import DynamicSystem
from modallab.rig.hardware import within
from modallab.rig.settings import STINGER


@dataclass(frozen=True)
class StingerRod:
    """A round rod, clamped at both ends."""

    diameter: float
    """m, diameter of the rod."""
    length: float
    """m, length of the rod."""
    modulus: float
    """N/m^2, Young's modulus."""
    density: float
    """kg/m^3, density."""

    def __post_init__(self) -> None:
        within("stinger.diameter", self.diameter, 1e-5, 0.1)
        within("stinger.length", self.length, STINGER.min_length, 10.0)
        within("stinger.modulus", self.modulus, 1e6, 1e13)
        within("stinger.density", self.density, 1.0, 1e5)
        # Together they make a spring and a mass that effects can be.
        within(
            "axial stiffness of the stinger",
            self.axial_stiffness,
            STINGER.min_stiffness,
            STINGER.max_stiffness,
        )
        within("bending stiffness of the stinger", self.bending_stiffness, 0.0, STINGER.max_bending_stiffness)
        within("mass of the stinger", self.mass, 0.0, STINGER.max_mass)

    @property
    def mass(self) -> float:
        """Its mass, kg."""
        return float(self.density * np.pi / 4 * self.diameter**2 * self.length)

    @property
    def axial_stiffness(self) -> float:
        """EA/L, N/m: 1992 thesis [D.5]."""
        return float(self.modulus * np.pi / 4 * self.diameter**2 / self.length)

    @property
    def bending_stiffness(self) -> float:
        """4EI/L, N m/rad: moment per rotation of one end, the other end clamped."""
        return float(self.modulus * np.pi / 16 * self.diameter**4 / self.length)

    @property
    def bending_frequency(self) -> float:
        """Of the first bending mode between two clamps, Hz.

        f = 0.890 d/L^2 sqrt(E/rho), where 0.890 = 4.730^2/(8 pi) is that of a Bernoulli beam. The 1992
        thesis [D.3] has 0.883 = (3 pi/2)^2/(8 pi): cosh x cos x = 1 solved as cos x = 0, 0.7 % lower.
        """
        speed = np.sqrt(self.modulus / self.density)
        return float(STINGER.clamped_root**2 / (8 * np.pi) * self.diameter / self.length**2 * speed)


@dataclass(frozen=True)
class StingerStiffness:
    """A stinger by its stiffness alone; without a mass."""

    axial_stiffness: float | None = None
    """N/m, axial stiffness; None: rigid."""
    bending_stiffness: float = 0.0
    """N m/rad, bending stiffness at the drive point."""
    lateral_stiffness: float = 0.0
    """N/m, lateral stiffness at the drive point."""

    mass: ClassVar[float] = 0.0

    def __post_init__(self) -> None:
        if self.axial_stiffness is not None:
            within(
                "stinger.axial_stiffness", self.axial_stiffness, STINGER.min_stiffness, STINGER.max_stiffness
            )
        within("stinger.bending_stiffness", self.bending_stiffness, 0.0, STINGER.max_bending_stiffness)
        least, most = (
            3 * self.bending_stiffness / length**2 for length in (STINGER.max_length, STINGER.min_length)
        )
        if self.lateral_stiffness != 0:
            within("stinger.lateral_stiffness", self.lateral_stiffness, least, most)

    @property
    def length(self) -> float:
        """Of the rod with this bending and this lateral stiffness, 4EI/L and 12EI/L^3, m."""
        if self.lateral_stiffness == 0:
            return STINGER.max_length
        return float(np.sqrt(3 * self.bending_stiffness / self.lateral_stiffness))


Stinger = StingerRod | StingerStiffness


def axial_frequency(stiffness: float, mass: float) -> float:
    """Return the frequency, Hz, of an armature, kg, on the stinger's axial stiffness, N/m [D.4].

    The structure is fixed at the drive point.
    """
    return float(np.sqrt(stiffness / mass) / (2 * np.pi))


def lateral_ends(system: DynamicSystem, drive: Dof) -> Iterator[tuple[FloatArray, NDArray[np.bool_]]]:
    """Yield the lateral and rotational DoFs of a drive point that a rod couples to, by plane.

    The rod leaves the structure against the sense in which it drives.

    Yields
    ------
    columns
        (n_dof, 1 or 2): lateral motion, and slope of the rod away from the structure; what the structure
        does not have is left out.
    free
        (2,) which of the two it has.
    """
    along = TRANSLATIONS.index(drive.direction)
    outward = -drive.sign * np.eye(3)[along]
    for lateral in (np.eye(3)[i] for i in range(3) if i != along):
        rotation_axis = np.cross(outward, lateral)
        columns = np.stack(
            [_motion(system, drive.node, "", lateral), _motion(system, drive.node, "R", rotation_axis)],
            axis=1,
        )
        free = np.asarray(columns.any(axis=0))
        if free.any():
            yield columns[:, free], free


def _motion(system: DynamicSystem, node: int, prefix: str, direction: FloatArray) -> FloatArray:
    """Return the (n_dof,) column of a node's translation along, or rotation about, a direction."""
    column = np.zeros(len(system.dofs))
    for name, share in zip(TRANSLATIONS, direction, strict=True):
        if share and (dof := Dof(node, prefix + name)) in system.dofs:
            column[system.index(dof)] = share
    return column
