"""Standard errors and remaining bias of fits to lines with leakage."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.extraction.preprocessing.random_errors import LineAccuracy
from modallab.extraction.preprocessing.settings import LEAKAGE
from modallab.extraction.single_mode.covariance_errors import rescreened, with_errors
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fit_data import FitData
from modallab.extraction.single_mode.fit_table import ConvergedFits, FitTable
from modallab.extraction.single_mode.fitting import fit_once
from modallab.extraction.single_mode.leakage_correction import leakage_corrections
from modallab.extraction.single_mode.leakage_feedback import LeakageFeedback, feedback
from modallab.extraction.single_mode.leaked_covariance import leaked_covariance
from modallab.extraction.single_mode.method import ExtractionMethod
from modallab.extraction.single_mode.residual_bias import residual_shift
from modallab.extraction.single_mode.settings import FEEDBACK


def with_leakage_errors(
    method: ExtractionMethod,
    damping_model: DampingModel,
    data: FitData,
    leakage: WindowLeakage,
    settled: ConvergedFits,
    accuracy: LineAccuracy | None,
) -> ConvergedFits:
    """Return the fits with standard errors and bias that include the leakage correction.

    Lines were corrected by the modes fitted to them, so that an error of a mode partly confirms itself: see
    `LeakageFeedback`. Fits with feedback above the setting depend on their starting values; they are rejected
    where other FRFs have fits below it.

    Parameters
    ----------
    method, damping_model, data, leakage
        As in `fit_all`.
    settled
        Result of `fit_all`.
    accuracy
        Random error of the lines; None without coherence.
    """
    kind = settled.inertance
    fits = fit_once(method, damping_model, data, settled.cleaned, kind)
    background = fits.residual + settled.other_modes

    def refit(eigenvalue: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        corrected = replace(fits, eigenvalue=eigenvalue)
        lines = (
            data.receptance * leakage_corrections(damping_model, data, leakage, corrected, background)
            - settled.other_modes
        )
        refitted = fit_once(method, damping_model, data, lines, kind)
        return refitted.eigenvalue, refitted.table.modal_constant

    uncorrected = fit_once(method, damping_model, data, data.receptance - settled.other_modes, kind).table
    loop = feedback(refit, fits.eigenvalue)
    covariance = leaked_covariance(method, damping_model, data, leakage, fits, settled.other_modes, accuracy)
    shift = residual_shift(method, damping_model, data, settled, fits)
    covariance = (
        covariance * fits.misfit_factor[..., None, None] ** 2 + shift[..., :, None] * shift[..., None, :]
    )
    table = with_errors(settled.table, loop.converged_covariance(covariance))
    bias = _remaining_bias(table, loop, _leakage_shift(table, uncorrected, data.spacing))
    screening = rescreened(settled.table, table, loop.strength < FEEDBACK.unsettled_strength, data.spacing)
    return replace(settled, table=replace(table, screening=screening, leakage_bias=bias))


def _leakage_shift(table: FitTable, uncorrected: FitTable, spacing: float) -> FloatArray:
    """Return the shift of frequency, Hz, and loss factor by leakage, (n_modes, n_frf, 2).

    Its bound, also used where uncorrected lines show no mode, is the centre of a line and its width.
    """
    identified = (table.frequency > 0) & (uncorrected.frequency > 0)
    line = spacing / np.where(table.frequency > 0, table.frequency, spacing)
    frequency_shift = np.where(identified, np.abs(uncorrected.frequency - table.frequency), np.inf)
    loss_factor_shift = np.where(identified, np.abs(uncorrected.loss_factor - table.loss_factor), np.inf)
    return np.stack([np.minimum(frequency_shift, spacing / 2), np.minimum(loss_factor_shift, line)], axis=2)


def _remaining_bias(table: FitTable, loop: LeakageFeedback, shift: FloatArray) -> FloatArray:
    """Return the bias that may remain, of the shape of `shift`.

    It has three parts: the uncorrected part of the shift amplified by feedback, or the whole shift if a mode
    has not converged in most FRFs; the change by further iterations; and the bias of a mean, a part e^2 of
    values that scatter by a part e about a non-linear function.
    """
    frequency, loss_factor = table.frequency, table.loss_factor
    identified = frequency > 0
    unsettled = (identified & (loop.strength >= FEEDBACK.unsettled_strength)).sum(axis=1) > identified.sum(
        axis=1
    ) / 2
    remaining = (
        np.maximum(LEAKAGE.remaining_fraction * (loop.strength - 1), unsettled[:, None])[:, :, None] * shift
    )
    relative = np.where(identified, table.loss_factor_error / np.where(identified, loss_factor, 1.0), 0.0)
    nonlinear = (relative**2)[:, :, None] * np.stack([loss_factor * frequency / 2, loss_factor], axis=2)
    stiffness = (2 * np.pi * np.where(identified, frequency, 1.0)) ** 2
    remainder = loop.remainder / stiffness
    unfinished = np.stack([np.abs(remainder.real) * frequency / 2, np.abs(remainder.imag)], axis=2)
    return np.asarray(remaining + nonlinear + unfinished)
