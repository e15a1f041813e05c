"""Backward elimination of modes that FRFs do not show, with poles outside the range."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.modal_model import DoubtfulMode
from modallab.core.numerics import SAFE_DIVISOR
from modallab.core.progress import Progress, part
from modallab.extraction.multi_mode.chart_settings import SELECTION
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.modal_fit import fit_modes, fitted_receptance
from modallab.extraction.multi_mode.refinement_settings import REFINEMENT
from modallab.extraction.multi_mode.split_modes import Merged, merged_in_ranges, merged_of_one_shape
from modallab.extraction.multi_mode.variable_projection import affected_by_outer_modes
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.line_noise import weights_from_residuals
from modallab.extraction.preprocessing.noise_model import INDEPENDENT_LINES, NoiseModel

BELOW_NOISE = "not above random error in any FRF"


@dataclass(frozen=True, eq=False)
class BandData:
    """Lines of a range with their weights."""

    freq: FloatArray
    """(n_lines,) Hz."""
    receptance: ComplexArray
    """(n_lines, n_frf) m/N."""
    weight: FloatArray
    """(n_lines, n_frf) one over E|error|^2."""
    weights_known: bool
    """Whether the weights are absolute; else only their ratios are plausible."""
    n_ref: int = 1
    """Number of references, and so of FRFs of each DoF."""
    drift_ranges: tuple[tuple[float, float], ...] = ()
    """Hz, ranges in which a mode drifts from FRF to FRF, and so is one mode."""
    noise: NoiseModel = INDEPENDENT_LINES
    """Common errors of the lines."""


@dataclass(frozen=True, eq=False)
class StartingPoles:
    """Initial values of the poles of a fit."""

    eigenvalue: ComplexArray
    """(n_modes,) omega_r^2 (1 + i eta_r), (rad/s)^2."""
    participation: ComplexArray | None
    """(n_modes, n_ref) factors; None if each FRF has its own constants."""

    def without(self, rows: BoolArray) -> "StartingPoles":
        """Return the poles that are not among `rows` (n_modes,)."""
        reach = self.participation
        return StartingPoles(self.eigenvalue[~rows], None if reach is None else reach[~rows])


@dataclass(frozen=True, eq=False)
class RefinedModes:
    """Fit of all modes of a range."""

    fit: ModalFit
    weight: FloatArray
    """(n_lines, n_frf) final weights of the fit."""
    left_out: tuple[DoubtfulMode, ...]
    """Rejected poles, with the reason."""
    drifts: tuple[str, ...] = ()
    """Drift of each mode that moves during the test, as text."""
    leakage_bias: FloatArray | None = None
    """(n_modes, 2) remaining bias of frequency, Hz, and loss factor by leakage; None without leakage."""
    residual_modes: tuple[tuple[float, float], ...] = ()
    """Intervals, Hz, of the modes that were found in the residual of a fit."""


def refine(
    band_data: BandData, start: StartingPoles, damping: Damping, progress: Progress
) -> RefinedModes | None:
    """Return the fit of all significant modes; None if there is none.

    Parameters
    ----------
    start
        Initial poles from a pole finder.
    damping
        Damping model.
    """
    return refine_all(band_data, _with_outer_modes(start, band_data.freq), damping, progress)


def refine_all(
    band_data: BandData, start: StartingPoles, damping: Damping, progress: Progress
) -> RefinedModes | None:
    """Return the fit of all significant modes as `refine`, from poles that include those out of band."""
    weight = band_data.weight
    n_reweighted = 0 if band_data.weights_known else REFINEMENT.reweighted_fits
    left_out: list[DoubtfulMode] = []
    drifts: list[str] = []
    merged = merged_in_ranges(start.eigenvalue, band_data.drift_ranges)
    start = replace(start, eigenvalue=merged.eigenvalue).without(merged.redundant)
    for n in range(REFINEMENT.iterations):
        step = part(progress, 1 - REFINEMENT.later_share**n, 1 - REFINEMENT.later_share ** (n + 1))
        fit = fit_modes(
            band_data.freq,
            band_data.receptance,
            weight,
            start.eigenvalue,
            damping=damping,
            participation=start.participation,
            noise=band_data.noise,
            progress=step,
        )
        start = StartingPoles(fit.eigenvalue, fit.participation)
        if n < n_reweighted:
            fitted = fitted_receptance(fit, band_data.freq, damping)
            weight = weights_from_residuals(band_data.receptance, fitted, band_data.weight)
            continue
        merged = _merged(fit, band_data)
        if merged.redundant.any():
            drifts += merged.notes
            start = replace(start, eigenvalue=merged.eigenvalue).without(merged.redundant)
            n_reweighted = n_reweighted and n + 2  # the weights were those of the split mode
            continue
        insignificant = insignificant_poles(fit, band_data.freq)
        if not insignificant.any():
            return RefinedModes(fit, weight, tuple(left_out), tuple(drifts))
        left_out += _below_noise(fit, insignificant)
        if not (between_ends(fit, band_data.freq) & (fit.loss_factor > 0) & ~insignificant).any():
            return None
        start = start.without(insignificant)
    return RefinedModes(fit, weight, tuple(left_out), tuple(drifts))


def _below_noise(fit: ModalFit, insignificant: BoolArray) -> list[DoubtfulMode]:
    """Return the insignificant poles of a fit as doubtful modes."""
    return [
        DoubtfulMode(float(fit.frequency[row]), float(fit.loss_factor[row]), BELOW_NOISE)
        for row in np.flatnonzero(insignificant)
    ]


def _merged(fit: ModalFit, band_data: BandData) -> Merged:
    """Return the poles with one for each mode that drifts from FRF to FRF, or in all FRFs alike."""
    merged = merged_in_ranges(fit.eigenvalue, band_data.drift_ranges)
    if merged.redundant.any():
        return merged
    return merged_of_one_shape(fit, between_ends(fit, band_data.freq) & (fit.loss_factor > 0))


def between_ends(fit: ModalFit, freq: FloatArray) -> BoolArray:
    """Return which poles lie inside the range."""
    return np.asarray((fit.frequency >= freq[0]) & (fit.frequency <= freq[-1]))


def insignificant_poles(fit: ModalFit, freq: FloatArray) -> BoolArray:
    """Return which poles inside the range are insignificant: shown by no FRF, or without precise frequency.

    Of two such poles that share a resonance only the less significant one is returned.
    """
    spacing = float(np.median(np.diff(freq)))
    width = fit.loss_factor * fit.frequency
    significance = (np.abs(fit.modal_constant) / np.maximum(fit.modal_constant_error, SAFE_DIVISOR)).max(
        axis=1
    )
    if fit.significance is not None:
        significance = np.maximum(significance, fit.significance)
    located = (fit.frequency_error < REFINEMENT.largest_error * np.maximum(width, spacing)) & (
        fit.loss_factor_error < np.abs(fit.loss_factor)
    )
    insignificant = ((significance < REFINEMENT.mode_errors) | ~located) & between_ends(fit, freq)
    near = np.abs(fit.frequency[:, None] - fit.frequency) < SELECTION.pair_distance * np.maximum(
        width[:, None], width
    )
    weaker = significance[None, :] < significance[:, None]
    return np.asarray(insignificant & ~(near & insignificant[None, :] & weaker).any(axis=1))


def _with_outer_modes(start: StartingPoles, freq: FloatArray) -> StartingPoles:
    """Return the poles with one outside either end of a range that is wide enough to determine them.

    A mode slightly outside is not constant over the range.
    """
    if not affected_by_outer_modes(freq):
        return start
    outer_frequencies = np.array([REFINEMENT.lower_start * freq[0], REFINEMENT.upper_start * freq[-1]])
    eigenvalue = np.append(
        start.eigenvalue, (2 * np.pi * outer_frequencies) ** 2 * (1 + 1j * REFINEMENT.starting_loss_factor)
    )
    reach = start.participation
    if reach is not None:  # initial factors of equal and of alternating signs
        unknown = (-1.0) ** np.multiply.outer(np.arange(2), np.arange(reach.shape[1]))
        reach = np.concatenate([reach, unknown])
    return StartingPoles(eigenvalue, reach)
