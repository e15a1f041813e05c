"""Modal model: natural frequencies, loss factors and mode shapes, measured or computed."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray, frozen
from modallab.core.dof import Dof
from modallab.core.frequency_inconsistency import FrequencyInconsistency
from modallab.core.reply import IntVector, NanFloat, Vector


@dataclass(frozen=True)
class Spread:
    """Scatter of one quantity over the FRFs from which it was estimated."""

    min: float
    """Smallest value."""
    max: float
    """Largest value."""
    mean: float
    """Arithmetic mean."""
    sd: float
    """Standard deviation of the sample, with n - 1."""
    n: int
    """Number of FRFs."""


@dataclass(frozen=True, eq=False)
class Mode:
    """One mode: eigenvalue (2 pi frequency)^2 (1 + i loss_factor), shape mass-normalised by transpose."""

    frequency: float
    """Hz, natural frequency."""
    loss_factor: float
    """Structural loss factor eta; twice the damping ratio where damping is viscous."""
    shape: ComplexArray
    """(n_dof,) 1/sqrt(kg), complex mode shape."""
    frequency_spread: Spread | None = None
    """Hz, scatter of the frequency over the FRFs."""
    loss_factor_spread: Spread | None = None
    """Scatter of the loss factor over the FRFs."""
    standard_errors: dict[str, NanFloat] = field(default_factory=dict)
    """Standard errors by name: `frequency` (Hz), `loss_factor`."""
    shape_errors: FloatArray | None = None
    """(n_dof,) 1/sqrt(kg), standard errors of the magnitude of the shape."""
    leakage_bias: dict[str, NanFloat] = field(default_factory=dict)
    """Bounds of the bias by leakage, by name: `frequency` (Hz), `loss_factor`; empty without leakage."""
    flags: tuple[str, ...] = ()
    """Warnings about this mode, as short codes."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "shape", frozen(self.shape, complex, (None,), name="shape"))
        if self.shape_errors is not None:
            errors = frozen(self.shape_errors, float, (len(self.shape),), name="shape_errors")
            object.__setattr__(self, "shape_errors", errors)

    @property
    def eigenvalue(self) -> complex:
        """omega_r^2 (1 + i eta_r), rad^2/s^2."""
        return complex((2 * np.pi * self.frequency) ** 2 * (1 + 1j * self.loss_factor))


@dataclass(frozen=True)
class DoubtfulMode:
    """A pole of a global method that was not accepted as a mode."""

    frequency: float
    """Hz, natural frequency of the pole."""
    loss_factor: NanFloat
    """Loss factor of the pole; below 0 if the pole is unstable."""
    reason: str
    """Why the pole is not among the modes."""


def frf_names(dofs: Sequence[Dof], references: Sequence[Dof]) -> tuple[str, ...]:
    """Return FRFs by name, DoF by DoF: `5:+Y`, or of several references `5:+Y / 1:+Y`."""
    if len(references) < 2:
        return tuple(str(dof) for dof in dofs)
    return tuple(f"{dof} / {reference}" for dof in dofs for reference in references)


@dataclass(frozen=True, eq=False)
class StabilisationChart:
    """Stabilisation chart: poles of a global method at rising model orders."""

    order: IntVector
    """(n_poles,) order of the polynomial with this pole."""
    frequency: Vector
    """Hz, (n_poles,) natural frequency of each pole."""
    loss_factor: Vector
    """(n_poles,) loss factor of each pole."""
    stability: IntVector
    """(n_poles,) agreement with a pole of the order before: 0 new, 1 in frequency, 2 in damping too,
    3 in the participation vector too."""
    mode: IntVector
    """(n_poles,) index of the mode that the pole belongs to, from 0; -1 for none."""

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
    """Modes in rising natural frequency."""
    dofs: tuple[Dof, ...]
    """Degrees of freedom of the mode shapes."""
    normalisation: Literal["mass", "none"] = "mass"
    """`mass`: shapes are mass-normalised; `none`: their scale is arbitrary."""
    method: str = ""
    """Extraction method, or `synthetic`."""
    references: tuple[Dof, ...] = ()
    """DoFs common to several FRFs: drive points, or fixed responses of a roving hammer test; empty for modes
    that are not from FRFs. FRFs are ordered DoF by DoF, and by reference at each DoF."""
    fitted_frequency: FloatArray | None = None
    """Hz, (n_modes, n_frf) natural frequency fitted to each FRF; NaN where it does not show the mode."""
    fitted_loss_factor: FloatArray | None = None
    """(n_modes, n_frf) loss factor fitted to each FRF; NaN where it does not show the mode."""
    modal_constant: ComplexArray | None = None
    """1/kg, (n_modes, n_frf) modal constants."""
    modal_constant_error: FloatArray | None = None
    """1/kg, (n_modes, n_frf) standard error of the real and of the imaginary part."""
    fitted_lines: IntArray | None = None
    """(n_modes, n_frf, 2) first and last line above 0 Hz of each single-mode fit."""
    residuals: ComplexArray | None = None
    """(2, n_frf) lower residual (1/kg, -m/omega^2) and upper residual (m/N)."""
    out_of_band_eigenvalue: ComplexArray | None = None
    """(rad/s)^2, (n_beyond,) eigenvalues of modes outside the range whose resonances bend the FRFs in it:
    terms A/(lambda - omega^2) for any damping model."""
    out_of_band_constant: ComplexArray | None = None
    """1/kg, (n_beyond, n_frf) modal constants A of these modes."""
    resynthesis_error: FloatArray | None = None
    """(n_frf,) rms misfit of the synthesised FRF over the rms of the FRF, over the lines of `ranges`."""
    ranges: tuple[tuple[float, float], ...] = ()
    """Hz, first and last line of each range that the modes were extracted from."""
    frequency_inconsistency: FrequencyInconsistency | None = None
    """Frequency differences between the FRFs; None where they agree."""
    chart: StabilisationChart | None = None
    """Stabilisation chart of a global method."""
    doubtful: tuple[DoubtfulMode, ...] = ()
    """Poles within the range that are not among the modes, each with the reason, in ascending frequency."""
    choices: dict[str, str] = field(default_factory=dict)
    """Value of each option in words, and the reason for it."""
    options: dict[str, int | float | str | None] = field(default_factory=dict)
    """Options of the extraction method as asked for; None was left to the method."""
    exclude: tuple[tuple[float, float], ...] = ()
    """Hz, lower and upper end of bands whose lines were left out of the extraction."""
    notes: tuple[str, ...] = ()
    """Remarks on the extraction, in sentences."""

    @property
    def drive(self) -> Dof | None:
        """Common DoF of all FRFs; None where there is none, or several."""
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
