"""Covariance of a mode that is fitted to lines with leakage."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.preprocessing.leakage import SinglePole, WindowLeakage
from modallab.extraction.preprocessing.leaked_lines import LineErrors, leaked_lines, white_error_correlation
from modallab.extraction.preprocessing.line_noise import coherence_correction
from modallab.extraction.preprocessing.random_errors import LineAccuracy, random_errors, relative_variance
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.preprocessing.settings import LEAKED_LINES
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fit_data import FitData
from modallab.extraction.single_mode.fit_table import FitIteration
from modallab.extraction.single_mode.influence import influence
from modallab.extraction.single_mode.leakage_correction import inertance_poles
from modallab.extraction.single_mode.method import ExtractionMethod


def line_accuracy(responses: Responses, index: IntArray) -> LineAccuracy:
    """Return the random error of the lines of every fit.

    Parameters
    ----------
    responses
        With coherence.
    index
        (n_modes, n_frf, n_lines) index of each line on the frequency axis.
    """
    n, column = responses.averages, np.arange(index.shape[1])[None, :, None]
    size = np.abs(responses.receptance[index, column]) ** 2
    variance = responses.variance[index, column]
    determined = np.isfinite(variance) & (size > 0)
    return LineAccuracy(
        coherence_correction(n) * np.where(determined, variance, 0.0) / np.where(determined, size, 1.0), n
    )


def leaked_covariance(
    method: ExtractionMethod,
    damping_model: DampingModel,
    data: FitData,
    leakage: WindowLeakage,
    fits: FitIteration,
    other_modes: ComplexArray,
    accuracy: LineAccuracy | None,
) -> FloatArray:
    """Return the covariance of each fit with its correction fixed, (n_modes, n_frf, 4, 4).

    It is that of real and imaginary part of the eigenvalue, (rad/s)^2, and of the modal constant, 1/kg. The
    errors of the lines consist of leakage of the mode, and of white noise for what coherence shows in
    addition; the correction of a line does not change its relative error.

    Parameters
    ----------
    method, damping_model, data, leakage
        As in `fit_all`.
    fits
        Fits to cleaned lines.
    other_modes
        (n_modes, n_frf, n_lines) receptance of the other modes, m/N.
    accuracy
        Of the same lines; None without coherence: then lines are independent, with errors from their weights.
    """
    (n_modes, n_frf, n_lines), background = data.freq.shape, fits.residual + other_modes
    receptance = (
        damping_model.response(data.freq, fits.eigenvalue[..., None], fits.table.modal_constant[..., None])
        + background
    )
    step = max(LEAKED_LINES.pairs_in_memory // n_lines**2, 1)
    out = np.empty((n_modes, n_frf, 4, 4))
    for m, (response, drive) in enumerate(inertance_poles(damping_model, data, fits, background)):
        for start in range(0, n_frf, step):
            frfs = slice(start, start + step)
            if accuracy is None:
                variance = relative_variance(data.weight[m, frfs], receptance[m, frfs])
                errors = LineErrors.circular(variance[..., None] * np.eye(n_lines))
            else:
                errors = _errors(
                    leakage,
                    data.freq[m, frfs],
                    data.spacing,
                    response.subset(frfs),
                    drive.subset(frfs),
                    replace(accuracy, variance=accuracy.variance[m, frfs]),
                )
            line_influence = influence(method, damping_model, data, fits, m, frfs) * receptance[m, frfs, None]
            out[m, frfs] = errors.propagate(line_influence)
    return out


def _errors(
    leakage: WindowLeakage,
    freq: FloatArray,
    spacing: float,
    response: SinglePole,
    drive: SinglePole,
    accuracy: LineAccuracy,
) -> LineErrors:
    """Return the errors of the lines of some FRFs, each (n_frf, n_lines)."""
    leaked = leaked_lines(leakage, freq, spacing, response, drive)
    return random_errors(leaked, white_error_correlation(leakage, freq, spacing), accuracy).specific
