"""Standard errors and screening of fits from their covariance."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.extraction.single_mode.fit_table import FitTable
from modallab.extraction.single_mode.screening import Screening, screen


def with_errors(table: FitTable, covariance: FloatArray) -> FitTable:
    """Return the table with errors from the covariance of each fit, (n_modes, n_frf, 4, 4).

    The error of a modal constant is that of its modulus. Fits without a determined covariance are unchanged.
    """
    identified, good = table.frequency > 0, table.screening.good
    frequency, loss_factor = np.where(identified, table.frequency, 1.0), table.loss_factor
    stiffness = (2 * np.pi * frequency) ** 2
    zeros, ones = np.zeros_like(frequency), np.ones_like(frequency)
    size = np.abs(table.modal_constant)
    phase = table.modal_constant / np.where(size > 0, size, 1.0)

    def error(*slope: FloatArray) -> FloatArray:
        along = np.stack(slope, axis=-1)
        return np.asarray(np.sqrt(np.maximum(np.einsum("...p,...pq,...q", along, covariance, along), 0.0)))

    frequency_error = error(ones, zeros, zeros, zeros) / (8 * np.pi**2 * frequency)
    loss_factor_error = error(-loss_factor, ones, zeros, zeros) / stiffness
    constant_error = error(zeros, zeros, phase.real, phase.imag)
    determined = identified & (frequency_error > 0) & (loss_factor_error > 0)
    return replace(
        table,
        frequency_error=np.where(determined, frequency_error, table.frequency_error),
        loss_factor_error=np.where(determined, loss_factor_error, table.loss_factor_error),
        modal_constant_error=np.where(
            determined & good & (constant_error > 0), constant_error, table.modal_constant_error
        ),
    )


def rescreened(previous: FitTable, table: FitTable, settled: BoolArray, spacing: float) -> Screening:
    """Return the screening by the larger errors; the previous one for a mode without accepted fits."""
    identified = (table.frequency > 0) & settled
    errors = table.frequency_error, table.loss_factor_error
    screening = screen(table.frequency, table.loss_factor, *errors, identified, spacing)
    accepted = screening.good.any(axis=1, keepdims=True)
    return Screening(
        good=np.where(accepted, screening.good, previous.screening.good),
        unsure=np.where(accepted, screening.unsure, previous.screening.unsure),
        outlying=np.where(accepted, screening.outlying, previous.screening.outlying),
    )
