"""Modes as a measurement or a model gives them."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, frozen
from modallab.core.dof import Dof


@dataclass(frozen=True)
class Spread:
    """How one number scatters over the FRFs it was read from; `sd` with n - 1."""

    min: float
    max: float
    mean: float
    sd: float
    n: int


@dataclass(frozen=True, eq=False)
class Mode:
    """One mode: eigenvalue (2 pi frequency)^2 (1 + i loss_factor), shape mass-normalised by transpose."""

    frequency: float  # Hz
    loss_factor: float
    shape: ComplexArray  # (n_dof,) 1/sqrt(kg)
    frequency_spread: Spread | None = None
    loss_factor_spread: Spread | None = None
    standard_errors: dict[str, float] = field(default_factory=dict)  # of frequency, loss_factor
    shape_errors: FloatArray | None = None  # (n_dof,) of |shape|, 1/sqrt(kg)
    flags: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "shape", frozen(self.shape, complex, (None,), name="shape"))
        if self.shape_errors is not None:
            errors = frozen(self.shape_errors, float, (len(self.shape),), name="shape_errors")
            object.__setattr__(self, "shape_errors", errors)

    @property
    def eigenvalue(self) -> complex:
        """omega_r^2 (1 + i eta_r), rad^2/s^2."""
        return complex((2 * np.pi * self.frequency) ** 2 * (1 + 1j * self.loss_factor))


@dataclass(frozen=True, eq=False)
class ModalModel:
    """A consistent set of modes at named DoFs, in rising frequency."""

    modes: tuple[Mode, ...]
    dofs: tuple[Dof, ...]
    normalisation: Literal["mass", "none"] = "mass"
    method: str = ""
    # per FRF: (n_modes, n_out) Hz, -, and 1/kg; NaN where an FRF did not show the mode
    fitted_frequency: FloatArray | None = None
    fitted_loss_factor: FloatArray | None = None
    modal_constant: ComplexArray | None = None
    notes: tuple[str, ...] = ()

    @property
    def frequencies(self) -> FloatArray:
        """(n_modes,) Hz."""
        return np.array([mode.frequency for mode in self.modes])

    @property
    def loss_factors(self) -> FloatArray:
        """(n_modes,)."""
        return np.array([mode.loss_factor for mode in self.modes])

    @property
    def shapes(self) -> ComplexArray:
        """(n_dof, n_modes), 1/sqrt(kg)."""
        return np.stack([mode.shape for mode in self.modes], axis=1)
