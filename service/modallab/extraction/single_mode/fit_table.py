"""Results of the single-mode fits of every mode in every FRF."""

from dataclasses import dataclass

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.extraction.single_mode.screening import Screening


@dataclass(frozen=True, eq=False)
class FitTable:
    """Fits of all modes in all FRFs; every array (n_modes, n_frf), standard errors include the misfit."""

    frequency: FloatArray
    """Hz."""
    loss_factor: FloatArray
    """Structural loss factor."""
    modal_constant: ComplexArray
    """1/kg, of receptance; at the mean eigenvalue of the other FRFs where the fit is not good."""
    frequency_error: FloatArray
    """Hz, standard error."""
    loss_factor_error: FloatArray
    """Standard error."""
    modal_constant_error: FloatArray
    """1/kg, standard error."""
    screening: Screening
    """Acceptance of every fit."""
    lines: IntArray | None = None
    """(n_modes, n_frf, 2) first and last line of each fit."""
    leakage_bias: FloatArray | None = None
    """(n_modes, n_frf, 2) remaining bias by leakage of frequency, Hz, and loss factor; None without
    leakage."""


@dataclass(frozen=True, eq=False)
class ConvergedFits:
    """Converged fits with the lines of the final iteration."""

    table: FitTable
    """Fits of all modes in all FRFs."""
    cleaned: ComplexArray
    """(n_modes, n_frf, n_lines) m/N, lines without leakage and without the other modes."""
    other_modes: ComplexArray
    """(n_modes, n_frf, n_lines) m/N, response of the other modes."""
    inertance: BoolArray
    """(n_modes,) True where the mode was fitted to inertance."""
    remaining_noise: FloatArray | None = None
    """(n_modes, n_frf) weighted squares that noise alone leaves of correlated lines; None: not computed."""


@dataclass(frozen=True, eq=False)
class FitIteration:
    """Fits of one iteration."""

    table: FitTable
    """Fits of all modes in all FRFs."""
    eigenvalue: ComplexArray
    """(n_modes, n_frf) (rad/s)^2."""
    residual: ComplexArray
    """(n_modes, n_frf, n_lines) m/N, receptance of the constant beside each mode."""
    inertance: BoolArray
    """(n_modes,) True where the mode was fitted to inertance."""
    misfit_factor: FloatArray
    """(n_modes, n_frf) factor by which the misfit increases the standard errors."""
