"""Covariance of a mode that is fitted to lines with leakage."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.preprocessing.leakage import SinglePole, WindowLeakage
from modallab.extraction.preprocessing.leaked_lines import LineErrors, leaked_lines, white_error_correlation
from modallab.extraction.preprocessing.line_noise import coherence_correction
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.preprocessing.settings import LEAKED_LINES
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fitting import FitData, FitIteration, inertance_poles
from modallab.extraction.single_mode.influence import influence
from modallab.extraction.single_mode.method import ExtractionMethod


@dataclass(frozen=True, eq=False)
class LineAccuracy:
    """Random error of the lines of every fit, from coherence."""

    variance: FloatArray
    """(n_modes, n_frf, n_lines) E|error|^2 of receptance over its squared modulus."""
    averages: float
    """Effective number of averages."""


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
                errors = _independent(data.weight[m, frfs], receptance[m, frfs])
            else:
                errors = _errors(leakage, data, m, frfs, (response, drive), accuracy)
            line_influence = influence(method, damping_model, data, fits, m, frfs) * receptance[m, frfs, None]
            out[m, frfs] = errors.propagate(line_influence)
    return out


def _independent(weight: FloatArray, receptance: ComplexArray) -> LineErrors:
    exact = weight * np.abs(receptance) ** 2
    variance = np.where(exact > 0, 1 / np.where(exact > 0, exact, 1.0), 0.0)
    covariance = (variance[..., None] * np.eye(variance.shape[-1])).astype(complex)
    return LineErrors(covariance, np.zeros_like(covariance))


def _errors(
    leakage: WindowLeakage,
    data: FitData,
    m: int,
    frfs: slice,
    poles: tuple[SinglePole, SinglePole],
    accuracy: LineAccuracy,
) -> LineErrors:
    freq = data.freq[m, frfs]
    frf_poles = (
        SinglePole(pole.eigenvalue[frfs], pole.constant[frfs], pole.residual[frfs]) for pole in poles
    )
    leaked = leaked_lines(leakage, freq, data.spacing, *frf_poles).errors
    covariance, relation = leaked.covariance / accuracy.averages, leaked.relation / accuracy.averages
    leaked_variance = np.diagonal(covariance, axis1=-2, axis2=-1).real
    noise_amplitude = np.sqrt(np.maximum(accuracy.variance[m, frfs] - leaked_variance, 0.0))
    noise = (
        noise_amplitude[..., :, None]
        * noise_amplitude[..., None, :]
        * white_error_correlation(leakage, freq, data.spacing)
    )
    return LineErrors(covariance + noise, relation)
