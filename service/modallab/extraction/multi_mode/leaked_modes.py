"""Standard errors and remaining bias of modes fitted to corrected lines."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.leakage_correction import (
    LeakageCorrection,
    corrected_lines,
    leaked_weights,
)
from modallab.extraction.multi_mode.leakage_settings import LEAKED_MODES
from modallab.extraction.multi_mode.leaked_covariance import with_leaked_errors
from modallab.extraction.multi_mode.modal_fit import fit_modes, one_step
from modallab.extraction.multi_mode.refinement import BandData, RefinedModes
from modallab.extraction.options import Damping


def with_leakage_errors(
    refined: RefinedModes, band_data: BandData, leaked: LeakageCorrection, damping: Damping
) -> RefinedModes:
    """Return the modes with the errors of the reference modes, and the bias that may remain.

    Corrected lines partly confirm the reference modes that corrected them: their scatter does not show an
    error of these. Errors of the reference modes are therefore propagated by difference quotients; a
    reference mode too imprecise for that gives its own error to the mode. The remaining bias consists of a
    part of the shift by the correction, from a fit of uncorrected lines, and of the propagated bias of the
    reference mode. A mode without a reference keeps all its leakage: up to a line's width of damping, and
    half a line in frequency.

    Parameters
    ----------
    refined
        Fit to corrected lines.
    band_data
        Lines before correction.
    leaked
        Leakage correction.
    damping
        Damping model.
    """
    has_covariance = band_data.weights_known and band_data.n_ref == 1 and np.isfinite(leaked.averages)
    refined = replace(refined, fit=_with_correlated_lines(refined.fit, leaked.leakage.error_correlation))
    if has_covariance:
        refined = replace(refined, fit=with_leaked_errors(refined, band_data, leaked, damping))
    fit, spacing = refined.fit, float(np.median(np.diff(band_data.freq)))
    full_bias = np.stack([np.full(len(fit.frequency), spacing / 2), spacing / fit.frequency], axis=1)
    full_bias[:, 1] = np.minimum(full_bias[:, 1], fit.loss_factor)  # leakage adds damping
    if leaked.modes is None:
        return replace(refined, leakage_bias=full_bias)
    reference_modes = leaked.modes
    nearest, matched = _nearest_reference(fit, reference_modes, spacing)
    imprecise = (
        matched
        & (
            reference_modes.loss_factor_error
            > LEAKED_MODES.largest_relative_error * reference_modes.loss_factor
        )[nearest]
    )
    sensitivity = _sensitivity(refined, band_data, leaked, damping)
    bias = np.where(imprecise[:, None], leaked.bias[nearest], _propagated_bias(sensitivity, leaked, nearest))
    bias = np.maximum(
        _remaining_bias(refined, band_data, damping), np.where(matched[:, None], bias, full_bias)
    )
    narrow = matched & (fit.loss_factor * fit.frequency < LEAKED_MODES.narrow * spacing)
    fit = _with_imprecise_references(
        _with_reference_errors(fit, sensitivity), reference_modes, nearest, imprecise, narrow
    )
    return replace(refined, fit=fit, leakage_bias=bias)


@dataclass(frozen=True, eq=False)
class _Sensitivity:
    """Change of the modes if all reference modes change by a standard error of frequency or damping."""

    parameters: FloatArray
    """(2, n_modes, 2) frequency, Hz, and loss factor."""
    constant: FloatArray
    """(2, n_modes, n_frf) 1/kg, of either part."""


def _sensitivity(
    refined: RefinedModes, band_data: BandData, leaked: LeakageCorrection, damping: Damping
) -> _Sensitivity:
    reference_modes = leaked.modes
    assert reference_modes is not None

    def followed(frequency: FloatArray, loss_factor: FloatArray) -> tuple[FloatArray, ComplexArray]:
        eigenvalue = (2 * np.pi * frequency) ** 2 * (1 + 1j * loss_factor)
        perturbed_correction = replace(leaked, modes=replace(reference_modes, eigenvalue=eigenvalue))
        lines = corrected_lines(band_data, perturbed_correction, damping).receptance
        stepped, constant = one_step(band_data.freq, lines, refined.weight, refined.fit, damping=damping)
        return np.stack([np.sqrt(stepped.real) / (2 * np.pi), stepped.imag / stepped.real], axis=1), constant

    unperturbed, constant = followed(reference_modes.frequency, reference_modes.loss_factor)
    steps = (
        (LEAKED_MODES.step * reference_modes.frequency_error, 0.0),
        (0.0, LEAKED_MODES.step * reference_modes.loss_factor_error),
    )
    perturbed = [
        followed(reference_modes.frequency + df, reference_modes.loss_factor + dn) for df, dn in steps
    ]
    return _Sensitivity(
        np.stack([end - unperturbed for end, _ in perturbed]) / LEAKED_MODES.step,
        np.stack([np.abs(end - constant) for _, end in perturbed]) / LEAKED_MODES.step / np.sqrt(2),
    )


def _propagated_bias(sensitivity: _Sensitivity, leaked: LeakageCorrection, nearest: IntArray) -> FloatArray:
    """Return the bias of each mode by that of its reference mode, (n_modes, 2)."""
    reference_modes = leaked.modes
    assert reference_modes is not None
    error = np.stack([reference_modes.frequency_error, reference_modes.loss_factor_error], axis=1)
    in_errors = (leaked.bias / np.maximum(error, SAFE_DIVISOR))[nearest]
    return np.asarray((np.abs(sensitivity.parameters) * in_errors.T[:, :, None]).sum(axis=0))


def _with_reference_errors(fit: ModalFit, sensitivity: _Sensitivity) -> ModalFit:
    """Return the fit with the propagated errors of the reference modes."""
    added = (sensitivity.parameters**2).sum(axis=0).T.ravel()
    constant = (sensitivity.constant**2).sum(axis=0)
    return replace(
        fit,
        eigenvalue_covariance=fit.eigenvalue_covariance + np.diag(added),
        modal_constant_error=np.sqrt(fit.modal_constant_error**2 + constant),
    )


def _with_correlated_lines(fit: ModalFit, error_correlation: float) -> ModalFit:
    """Return the fit with the errors of correlated lines."""
    return replace(
        fit,
        eigenvalue_covariance=error_correlation * fit.eigenvalue_covariance,
        modal_constant_error=np.sqrt(error_correlation) * fit.modal_constant_error,
    )


def _nearest_reference(
    fit: ModalFit, reference_modes: ModalFit, spacing: float
) -> tuple[IntArray, BoolArray]:
    """Return the reference mode nearest to each mode, and whether it is the same mode, both (n_modes,)."""
    distance = np.abs(fit.frequency[:, None] - reference_modes.frequency)
    nearest = distance.argmin(axis=1)
    reach = np.maximum((reference_modes.loss_factor * reference_modes.frequency)[nearest], spacing)
    return nearest, np.asarray(distance.min(axis=1) < reach)


def _remaining_bias(refined: RefinedModes, band_data: BandData, damping: Damping) -> FloatArray:
    """Return the part of the correction that may remain as bias, (n_modes, 2)."""
    fit = refined.fit
    uncorrected = fit_modes(
        band_data.freq,
        band_data.receptance,
        leaked_weights(fit.eigenvalue, band_data),
        fit.eigenvalue,
        damping=damping,
        participation=fit.participation,
    )
    damping_shift = fit.loss_factor - uncorrected.loss_factor
    spacing = float(np.median(np.diff(band_data.freq)))
    remaining = LEAKED_MODES.remaining_fraction * np.minimum(np.abs(damping_shift), fit.loss_factor)
    return np.stack([np.full_like(remaining, LEAKED_MODES.remaining_shift * spacing), remaining], axis=1)


def _with_imprecise_references(
    fit: ModalFit, reference_modes: ModalFit, nearest: IntArray, imprecise: BoolArray, narrow: BoolArray
) -> ModalFit:
    """Return the fit with errors not smaller than those of imprecise reference modes.

    Nor are those of the modal constants of narrow modes, which few lines determine, most of them corrected.
    """
    fit_error = np.concatenate([fit.frequency_error, fit.loss_factor_error])
    reference_error = np.concatenate(
        [reference_modes.frequency_error[nearest], reference_modes.loss_factor_error[nearest]]
    )
    added = np.where(np.tile(imprecise, 2), np.maximum(reference_error**2 - fit_error**2, 0.0), 0.0)
    constant = np.where((imprecise | narrow)[:, None], reference_modes.modal_constant_error[nearest], 0.0)
    return replace(
        fit,
        eigenvalue_covariance=fit.eigenvalue_covariance + np.diag(added),
        modal_constant_error=np.fmax(fit.modal_constant_error, constant),
    )
