"""Lowest modes of a structure, and synthetic measured modes with errors."""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.modal_model import ModalModel, Mode
from modallab.fe.modes import ModalBasis
from modallab.fe.system import DynamicSystem


def lowest_modes(system: DynamicSystem, count: int) -> tuple[ModalBasis, int]:
    """Return the first elastic modes, fewer where there are fewer, and the number of rigid-body modes.

    Raises
    ------
    InvalidInputError
        If no mode is asked for.
    """
    basis = system.first_modes(count)
    lowest = basis.elastic(count)
    # Rows after the DoFs are internal coordinates of attachments.
    return replace(lowest, shapes=lowest.shapes[: len(system.dofs)]), basis.n_rigid_body


def exact_modes(system: DynamicSystem, count: int) -> ModalModel:
    """Return the first elastic modes of a structure at all its DoFs."""
    rng = np.random.default_rng(0)  # unused: there is no noise
    return synthetic_modes(system, count, system.dofs, noise=ModeNoise(), rng=rng)


class Distribution(StrEnum):
    """Distribution of synthetic errors."""

    UNIFORM = "uniform"  # uniform between minus and plus the size
    NORMAL = "normal"  # the size is the standard deviation


@dataclass(frozen=True)
class ModeNoise:
    """Relative errors of eigenvalues and of shape entries."""

    eigenvalue: float = 0.0
    """1, size of the relative errors of eigenvalues."""
    eigenvector: float = 0.0
    """1, size of the relative errors of shape entries."""
    distribution: Distribution = Distribution.UNIFORM
    """Distribution of the errors."""

    def __post_init__(self) -> None:
        for name in ("eigenvalue", "eigenvector"):
            value = getattr(self, name)
            if not 0 <= value < 1:  # NaN fails too
                raise InvalidInputError(
                    f"{name} is out of bounds",
                    field=name,
                    value=value,
                    allowed=bounds(0, exclusive_maximum=1),
                )

    def factors(self, size: float, n: int, rng: np.random.Generator) -> FloatArray:
        """Return n factors around 1."""
        if self.distribution is Distribution.UNIFORM:
            return np.asarray(1 + rng.uniform(-size, size, n))
        return np.asarray(1 + size * rng.standard_normal(n))

    def standard_error(self, size: float) -> float:
        """Return the standard deviation of errors of that size."""
        return size / float(np.sqrt(3)) if self.distribution is Distribution.UNIFORM else size


def synthetic_modes(
    system: DynamicSystem,
    count: int,
    dofs: tuple[Dof, ...],
    *,
    noise: ModeNoise,
    rng: np.random.Generator,
) -> ModalModel:
    """Return synthetic measured modes of a structure at some DoFs, with random errors.

    Modes have the standard errors of the noise, and none without noise.

    Parameters
    ----------
    dofs
        DoFs of the shapes; a negative DoF changes the sign of the entry.

    Raises
    ------
    UnknownDofError
        If the structure has no such DoF.
    """
    basis, _ = lowest_modes(system, count)
    rows = [system.index(dof) for dof in dofs]
    signs = np.array([dof.sign for dof in dofs])
    squares = basis.eigenvalues.real * noise.factors(noise.eigenvalue, len(basis.eigenvalues), rng)
    noisy = noise.eigenvalue > 0 or noise.eigenvector > 0
    of_frequency = noise.standard_error(noise.eigenvalue) / 2
    of_shape = noise.standard_error(noise.eigenvector)
    modes = []
    for r, (square, loss_factor) in enumerate(zip(squares, basis.loss_factors, strict=True)):
        shape = signs * basis.shapes[rows, r] * noise.factors(noise.eigenvector, len(dofs), rng)
        frequency = float(np.sqrt(max(square, 0.0)) / (2 * np.pi))
        modes.append(
            Mode(
                frequency=frequency,
                loss_factor=float(loss_factor),
                shape=shape,
                standard_errors={"frequency": of_frequency * frequency} if noisy else {},
                shape_errors=of_shape * np.abs(basis.shapes[rows, r]) if noisy else None,
            )
        )
    modes.sort(key=lambda mode: mode.frequency)
    return ModalModel(modes=tuple(modes), dofs=dofs, method="synthetic")
