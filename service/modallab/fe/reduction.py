"""Model reduction: transformation from master to all degrees of freedom, and reduced matrices."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from scipy.linalg import eigh

from modallab.core.arrays import FloatArray, frozen
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.numerics import CURVATURE_ROUNDING
from modallab.core.parameters import Parameterised
from modallab.core.registry import Family
from modallab.fe.partition import Partition
from modallab.fe.system import DynamicSystem


@dataclass(frozen=True)
class Reduction(Parameterised, ABC):
    """Transformation of the master degrees of freedom to all degrees of freedom."""

    kind: ClassVar[str]
    summary: ClassVar[str]

    @abstractmethod
    def transformation(self, split: Partition) -> FloatArray:
        """Return T, (n, n_master): the motion of every row for a unit motion of each master.

        Parameters
        ----------
        split
            The system and its masters; rows after its DoFs are internal coordinates of attachments.

        Raises
        ------
        InvalidInputError
            If these masters do not determine the motion of all the others.
        """

    def at_mode(self, frequency: float) -> Self:
        """Return the reduction for a mode at `frequency`, Hz; by default the same for all modes."""
        return self

    def reaching(self, frequency: float) -> Self:
        """Return the reduction for modes up to `frequency`, Hz; by default the same for all bands."""
        return self

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the reduction by name."""
        return {name: float(getattr(self, name)) for name in self.specs()}


REDUCTIONS: Family[type[Reduction]] = Family("reduction", home="modallab.fe.reductions")


def reduction_of(kind: str, parameters: Mapping[str, float] | None = None) -> Reduction:
    """Return the reduction of a kind with its parameters.

    Raises
    ------
    InvalidInputError
        If the name or a number is unknown, or a value out of bounds.
    """
    cls, values = REDUCTIONS[kind], dict(parameters or {})
    for name in values.keys() - cls.specs().keys():
        raise InvalidInputError(
            f"{kind} has no parameter {name!r}",
            field="reduction",
            value=name,
            allowed=list(cls.specs()) or "no parameter",
        )
    return cls(**values)


def pencil_modes(mass: FloatArray, stiffness: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the modes of two full matrices: omega_r^2 (k,), rising, and mass-normalised shapes (n, k).

    Massless motions are excluded, k <= n, and shapes have the least norm for their mass. A negative
    omega_r^2 means a negative stiffness.

    Parameters
    ----------
    mass, stiffness
        (n, n) kg and N/m, symmetric; the mass not negative.
    """
    size = np.sqrt(np.maximum(np.diag(mass), 0.0))
    scale = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0)
    values, rotation = eigh(scale[:, None] * mass * scale)
    with_mass = values > CURVATURE_ROUNDING * values[-1]
    basis = scale[:, None] * rotation[:, with_mass] / np.sqrt(values[with_mass])
    squares, within = eigh(basis.T @ stiffness @ basis)
    shapes = basis @ within
    if not with_mass.all():
        moving, _ = np.linalg.qr(size[:, None] * rotation[:, with_mass])
        shapes = moving @ (moving.T @ shapes)
    return squares, shapes


@dataclass(frozen=True, eq=False)
class ReducedSystem:
    """Reduced mass and stiffness at the masters, and the transformation x = T x_master."""

    reduction: Reduction
    masters: tuple[Dof, ...]
    dofs: tuple[Dof, ...]
    transformation: FloatArray  # (n_dof, n_master)
    mass: FloatArray  # (n_master, n_master) T^T M T, kg
    stiffness: FloatArray  # (n_master, n_master) T^T K T, N/m

    def __post_init__(self) -> None:
        m = len(self.masters)
        shapes = {"transformation": (len(self.dofs), m), "mass": (m, m), "stiffness": (m, m)}
        for name, shape in shapes.items():
            object.__setattr__(self, name, frozen(getattr(self, name), float, shape, name=name))

    def modes(self) -> tuple[FloatArray, FloatArray]:
        """Return frequencies (k,), Hz, and mass-normalised shapes (n_master, k), k <= n_master.

        A reduction of k modes to more than k masters has k modes only.
        """
        squares, shapes = pencil_modes(self.mass, self.stiffness)
        return np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi), shapes


def reduce(system: DynamicSystem, masters: tuple[Dof, ...], reduction: Reduction) -> ReducedSystem:
    """Return the reduced system of a structure with its attachments.

    Parameters
    ----------
    masters
        DoFs that are kept; their signs do not matter, coordinates are in the positive sense.

    Raises
    ------
    UnknownDofError
        If the structure has no such DoF.
    InvalidInputError
        If a master is named twice, or the masters do not determine the motion of all the others.
    """
    split = Partition.of(system, masters)
    t = reduction.transformation(split)
    mass, stiffness = (t.T @ (matrix @ t) for matrix in (split.system.mass, split.system.stiffness))
    return ReducedSystem(
        reduction=reduction,
        masters=split.masters,
        dofs=system.dofs,
        transformation=t[: len(system.dofs)],
        mass=(mass + mass.T) / 2,  # symmetric but for rounding
        stiffness=(stiffness + stiffness.T) / 2,
    )
