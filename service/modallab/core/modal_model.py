"""Modes as a measurement or a model gives them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray, frozen
from modallab.core.dof import Dof
from modallab.core.frequency_inconsistency import FrequencyInconsistency


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
    # of frequency, loss_factor: what leakage may still move them by; empty where none leaks
    leakage_bias: dict[str, float] = field(default_factory=dict)
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


def frf_names(dofs: Sequence[Dof], references: Sequence[Dof]) -> tuple[str, ...]:
    """Return FRFs by name, DoF by DoF: `5:+Y`, or of several references `5:+Y / 1:+Y`."""
    if len(references) < 2:
        return tuple(str(dof) for dof in dofs)
    return tuple(f"{dof} / {reference}" for dof in dofs for reference in references)


@dataclass(frozen=True, eq=False)
class StabilisationChart:
    """Poles that a global method found at rising model orders, and which of them became modes."""

    order: IntArray  # (n_poles,) of the polynomial that has this pole
    frequency: FloatArray  # (n_poles,) Hz
    loss_factor: FloatArray  # (n_poles,)
    # (n_poles,) how far a pole agrees with one of the order before: 0 new, 1 in frequency, 2 and in damping,
    # 3 and in its vector
    stability: IntArray
    mode: IntArray  # (n_poles,) which mode it speaks for, counted from 0; -1 for none

    def __post_init__(self) -> None:
        n = len(self.order)
        for name, of in (
            ("order", int),
            ("frequency", float),
            ("loss_factor", float),
            ("stability", int),
            ("mode", int),
        ):
            object.__setattr__(self, name, frozen(getattr(self, name), of, (n,), name=name))


@dataclass(frozen=True, eq=False)
class ModalModel:
    """A consistent set of modes at named DoFs, in rising frequency."""

    modes: tuple[Mode, ...]
    dofs: tuple[Dof, ...]
    normalisation: Literal["mass", "none"] = "mass"
    method: str = ""
    # points that FRFs share: drive points, or responses while a hammer roves; none where modes are
    # not from FRFs. FRFs are counted DoF by DoF, at each of them reference by reference.
    references: tuple[Dof, ...] = ()
    # per FRF: (n_modes, n_frf) Hz, -, and 1/kg; NaN where an FRF did not show the mode
    fitted_frequency: FloatArray | None = None
    fitted_loss_factor: FloatArray | None = None
    modal_constant: ComplexArray | None = None
    modal_constant_error: FloatArray | None = None  # (n_modes, n_frf) 1/kg, of either part
    # (n_modes, n_frf, 2) first and last line above 0 Hz that each single-mode fit drew on
    fitted_lines: IntArray | None = None
    # (2, n_frf) what lies below the range, 1/kg: -m/omega^2; and above it, m/N
    residuals: ComplexArray | None = None
    # what lies so near the range that it bends the FRFs in it, `A/(lambda - omega^2)` whatever the law of
    # damping: (n_beyond,) (rad/s)^2 and (n_beyond, n_frf) 1/kg
    beyond_eigenvalue: ComplexArray | None = None
    beyond_constant: ComplexArray | None = None
    resynthesis_error: FloatArray | None = None  # (n_frf,) rms misfit of the modes over rms of the FRF
    wander: FrequencyInconsistency | None = None  # of the frequencies over the FRFs, None where they agree
    chart: StabilisationChart | None = None
    choices: dict[str, str] = field(default_factory=dict)  # option -> what was taken, and why
    options: dict[str, int | float | str | None] = field(default_factory=dict)
    """Options of the extraction method as asked for; None was left to the method."""
    notes: tuple[str, ...] = ()

    @property
    def drive(self) -> Dof | None:
        """The point that all FRFs share; None where there is none, or several."""
        return self.references[0] if len(self.references) == 1 else None

    @property
    def frfs(self) -> tuple[str, ...]:
        """(n_frf,) names of the FRFs, as `frf_names`."""
        return frf_names(self.dofs, self.references)

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
