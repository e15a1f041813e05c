"""Members of a structure: straight bars, flat plates and imported element matrices."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.errors import StructureError, bounds
from modallab.fe.structure_settings import ELEMENT, INPUT

# No beam is outside of these, and products of what is inside neither vanish nor overflow.


def positive(value: float, name: str) -> None:
    """Raise `StructureError` unless the value is positive and within the range of computation."""
    if not INPUT.min_positive <= value <= INPUT.max_property:  # NaN fails too
        allowed = bounds(INPUT.min_positive, INPUT.max_property)
        raise StructureError(f"{name} must be positive", field=name, value=value, allowed=allowed)


def not_negative(value: float, name: str) -> None:
    """Raise `StructureError` if the value is negative or out of the range of computation."""
    if not 0 <= value <= INPUT.max_property:
        allowed = bounds(0, INPUT.max_property)
        raise StructureError(f"{name} must not be negative", field=name, value=value, allowed=allowed)


def within(value: float, lowest: float, highest: float, name: str) -> None:
    """Raise `StructureError` unless the value lies between the bounds."""
    if not lowest <= value <= highest:
        raise StructureError(
            f"{name} is out of bounds", field=name, value=value, allowed=bounds(lowest, highest)
        )


@dataclass(frozen=True)
class Section:
    """A cross-section."""

    area: float  # m^2
    second_moment: float  # m^4
    name: str = ""
    shear_coefficient: float = ELEMENT.shear_coefficient  # kappa, share of the area that shears

    def __post_init__(self) -> None:
        positive(self.area, "area")
        positive(self.second_moment, "second_moment")
        within(
            self.shear_coefficient,
            INPUT.min_shear_coefficient,
            INPUT.max_shear_coefficient,
            "shear_coefficient",
        )


@dataclass(frozen=True)
class Material:
    """An isotropic material."""

    modulus: float  # N/m^2
    density: float  # kg/m^3
    name: str = ""
    poisson_ratio: float = 0.3

    def __post_init__(self) -> None:
        positive(self.modulus, "modulus")
        positive(self.density, "density")
        within(self.poisson_ratio, INPUT.min_poisson_ratio, INPUT.max_poisson_ratio, "poisson_ratio")

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)), N/m^2."""
        return self.modulus / (2 * (1 + self.poisson_ratio))


def _check_factors(member: "Member | Plate | MatrixElement") -> None:
    for name in ("mass_factor", "axial_factor", "bending_factor"):
        positive(getattr(member, name), name)
    if member.loss_factor is not None:
        not_negative(member.loss_factor, "loss_factor")


@dataclass(frozen=True)
class Member:
    """A bar; its factors multiply the matrices of its section and material."""

    number: int
    nodes: tuple[int, int]
    section: Section
    material: Material
    element: str = "frame"
    mass_factor: float = 1.0
    axial_factor: float = 1.0
    bending_factor: float = 1.0
    loss_factor: float | None = None  # None: by the structure's damping law
    group: str = ""

    def __post_init__(self) -> None:
        _check_factors(self)


@dataclass(frozen=True)
class Plate:
    """A flat element of constant thickness between three or four nodes, numbered round its perimeter."""

    number: int
    nodes: tuple[int, ...]
    thickness: float  # m
    material: Material
    mass_factor: float = 1.0
    axial_factor: float = 1.0  # in its plane
    bending_factor: float = 1.0
    loss_factor: float | None = None
    group: str = ""

    def __post_init__(self) -> None:
        positive(self.thickness, "thickness")
        _check_factors(self)
        if len(set(self.nodes)) != len(self.nodes) or len(self.nodes) not in (3, 4):
            raise StructureError(
                f"plate element {self.number} has not three or four corners",
                field="members",
                value=self.nodes,
                allowed="3 or 4 different nodes",
            )

    def check_corners(self, corners: Sequence[Sequence[float]]) -> None:
        """Raise `StructureError` unless the corners, m, go round a convex shape, one way or the other."""
        places = np.array(corners)[:, :2]
        sides = np.roll(places, -1, axis=0) - places
        preceding = np.roll(sides, 1, axis=0)
        area = preceding[:, 0] * sides[:, 1] - preceding[:, 1] * sides[:, 0]
        least = INPUT.min_corner_area * (sides**2).sum(axis=1).max()
        if not ((area > least).all() or (area < -least).all()):
            raise StructureError(
                f"plate element {self.number} is folded, hollow or flat",
                field="members",
                value=self.nodes,
                allowed="corners round a convex shape",
            )


@dataclass(frozen=True)
class MatrixElement:
    """An element given by its matrices, those of `index` among the structure's blocks."""

    number: int
    nodes: tuple[int, ...]
    index: int
    mass_factor: float = 1.0
    axial_factor: float = 1.0
    bending_factor: float = 1.0
    loss_factor: float | None = None
    group: str = ""

    def __post_init__(self) -> None:
        _check_factors(self)


AnyMember = Member | Plate | MatrixElement


def sides(member: AnyMember) -> tuple[tuple[int, int], ...]:
    """Return the node pairs of the lines that draw a member: a bar itself, the perimeter of a plate."""
    nodes = member.nodes
    if len(nodes) == 2:
        return ((nodes[0], nodes[1]),)
    return tuple(zip(nodes, (*nodes[1:], nodes[0]), strict=True)) if len(nodes) in (3, 4) else ()
