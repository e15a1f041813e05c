"""Standard errors of fits to lines whose errors the window of the records correlates."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.estimation.error_correlation import ErrorCorrelation
from modallab.extraction.preprocessing.leaked_lines import LineErrors
from modallab.extraction.preprocessing.line_noise import coherence_correction, has_coherence
from modallab.extraction.preprocessing.noise_model import with_conjugate_phase
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.preprocessing.settings import LEAKED_LINES
from modallab.extraction.single_mode.covariance_errors import rescreened, with_errors
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fit_data import FitData
from modallab.extraction.single_mode.fit_table import ConvergedFits, FitIteration
from modallab.extraction.single_mode.fitting import fit_once
from modallab.extraction.single_mode.influence import influence
from modallab.extraction.single_mode.method import ExtractionMethod
from modallab.extraction.single_mode.residual_bias import residual_shift


def with_correlated_errors(
    method: ExtractionMethod,
    damping_model: DampingModel,
    data: FitData,
    settled: ConvergedFits,
    responses: Responses,
    index: IntArray,
) -> ConvergedFits:
    """Return the fits with standard errors that include the correlation of the lines.

    Parameters
    ----------
    method, damping_model, data
        As in `fit_all`.
    settled
        Result of `fit_all`.
    responses
        With the correlation of the errors of lines.
    index
        (n_modes, n_frf, n_lines) index of each line on the frequency axis.
    """
    correlation = responses.correlation
    assert correlation is not None
    factor = coherence_correction(responses.averages) if has_coherence(responses) else 1.0
    fits = fit_once(method, damping_model, data, settled.cleaned, settled.inertance, screened=False)
    used = data.weight > 0
    deviation = np.where(used, np.sqrt(factor / np.where(used, data.weight, 1.0)), 0.0)
    parts = _error_parts(deviation, data, responses, index)
    (n_modes, n_frf, n_lines), place = data.freq.shape, np.rint(data.freq / data.spacing).astype(np.int64)
    covariance, absorbed = np.empty((n_modes, n_frf, 4, 4)), np.empty((n_modes, n_frf))
    step = max(LEAKED_LINES.pairs_in_memory // n_lines**2, 1)
    for m in range(n_modes):
        for start in range(0, n_frf, step):
            frfs = slice(start, start + step)
            errors = _line_errors(correlation, place[m, frfs], [part[m, frfs] for part in parts])
            covariance[m, frfs] = errors.propagate(influence(method, damping_model, data, fits, m, frfs))
            relative = errors.covariance * np.sqrt(
                data.weight[m, frfs, :, None] * data.weight[m, frfs, None, :]
            )
            absorbed[m, frfs] = _absorbed(data, fits, m, frfs, relative / factor)
    mode = damping_model.response(data.freq, fits.eigenvalue[..., None], fits.table.modal_constant[..., None])
    squares = (data.weight * np.abs(settled.cleaned - mode - fits.residual) ** 2).sum(axis=(1, 2))
    # one number of all FRFs: correlated errors leave little freedom to the lines of one
    remaining = factor * np.maximum(used.sum(axis=2) - absorbed, 0.0)
    misfit = np.maximum(squares / np.maximum(remaining.sum(axis=1), 1.0), 1.0)
    shift = residual_shift(method, damping_model, data, settled, fits)
    covariance = covariance * misfit[:, None, None, None] + shift[..., :, None] * shift[..., None, :]
    table = with_errors(settled.table, covariance)
    screening = rescreened(settled.table, table, np.ones(table.frequency.shape, bool), data.spacing)
    return replace(settled, table=replace(table, screening=screening), remaining_noise=remaining)


def _error_parts(
    deviation: FloatArray, data: FitData, responses: Responses, index: IntArray
) -> list[ComplexArray]:
    """Return the independent parts of the lines' errors, each (n_modes, n_frf, n_lines).

    Noise of the force has the phase of the FRF.
    """
    noise, column = responses.noise, np.arange(index.shape[1])[None, :, None]
    by_force = np.zeros(index.shape) if noise is None else noise.force_share[index, column]
    by_noise = np.asarray(np.sqrt(1 - by_force) * deviation, complex)
    of_force = np.asarray(np.sqrt(by_force) * deviation, complex)
    return [by_noise, with_conjugate_phase(of_force, data.receptance.conj())]


def _line_errors(correlation: ErrorCorrelation, place: IntArray, parts: list[ComplexArray]) -> LineErrors:
    """Return the covariance of the errors of lines at places (n_frf, n_lines) on the frequency axis."""
    of_lines = correlation.between(place[:, :, None] - place[:, None, :])
    by_part = [part[:, :, None] * part[:, None, :].conj() for part in parts]
    return LineErrors(np.sum(by_part, axis=0) * of_lines, np.zeros(of_lines.shape, complex))


def _absorbed(data: FitData, fits: FitIteration, m: int, frfs: slice, of_lines: ComplexArray) -> FloatArray:
    """Return the part of the squared errors that a mode and a constant absorb, (n_frf,), in lines.

    Parameters
    ----------
    of_lines
        (n_frf, n_lines, n_lines) covariance of the errors over their standard deviations.
    """
    x, weight = data.x[m, frfs], data.weight[m, frfs]
    gap = fits.eigenvalue[m, frfs, None] - x
    columns = np.stack([1 / gap**2, 1 / gap, np.ones_like(gap)], axis=-1)
    kind = np.maximum(x, SAFE_DIVISOR) if fits.inertance[m] else np.ones_like(x)
    scale = np.linalg.norm(columns, axis=1, keepdims=True)
    basis = np.linalg.qr((np.sqrt(weight) / kind)[..., None] * columns / scale)[0]
    return np.asarray(np.einsum("jkc,jkl,jlc->j", basis.conj(), of_lines, basis, optimize=True).real)
