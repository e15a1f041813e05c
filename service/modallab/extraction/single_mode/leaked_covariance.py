"""The covariance of a mode that is fitted to leaked lines."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.preprocessing.leakage import SinglePole, WindowLeakage
from modallab.extraction.preprocessing.leaked_lines import LineErrors, leaked_lines, white_error_correlation
from modallab.extraction.preprocessing.line_noise import coherence_correction
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fitting import Data, Round, poles
from modallab.extraction.single_mode.influence import influence
from modallab.extraction.single_mode.method import ExtractionMethod

AT_ONCE = 2**18  # pairs of lines


@dataclass(frozen=True, eq=False)
class LineSpectra:
    """What coherence tells of the lines of every fit."""

    variance: FloatArray  # (n_modes, n_frf, n_lines) E|error|^2 of receptance over its square
    averages: float


def line_spectra(responses: Responses, index: IntArray) -> LineSpectra:
    """Return how exact the lines are that fits draw on.

    A coherence estimated from n averages says on average (n - 2)/n of the error there is.

    Parameters
    ----------
    index
        (n_modes, n_frf, n_lines) which line of the axis each is.
    """
    n, column = responses.averages, np.arange(index.shape[1])[None, :, None]
    size = np.abs(responses.receptance[index, column]) ** 2
    variance = responses.variance[index, column]
    known = np.isfinite(variance) & (size > 0)
    return LineSpectra(
        coherence_correction(n) * np.where(known, variance, 0.0) / np.where(known, size, 1.0), n
    )


def leaked_covariance(
    method: ExtractionMethod,
    law: DampingModel,
    data: Data,
    leakage: WindowLeakage,
    now: Round,
    others: ComplexArray,
    known: LineSpectra | None,
) -> FloatArray:
    """Return the covariance of each fit, the lines' correction held, (n_modes, n_frf, 4, 4).

    Of real and imaginary part of the eigenvalue, (rad/s)^2, and of the modal constant, 1/kg. Errors of the
    lines are those of leakage about the mode, and what coherence shows beyond as white noise; a line's
    correction leaves its relative error as it is.

    Parameters
    ----------
    method, law, data, leakage
        As of `fit_all`.
    now
        Fits to cleaned lines.
    others
        (n_modes, n_frf, n_lines) receptance of the other modes, m/N.
    known
        Of the same lines; None without a coherence: then lines are independent, their weights their errors.
    """
    (n_modes, n_frf, n_lines), rest = data.freq.shape, now.rest + others
    whole = law.response(data.freq, now.eigenvalue[..., None], now.table.modal_constant[..., None]) + rest
    step = max(AT_ONCE // n_lines**2, 1)
    out = np.empty((n_modes, n_frf, 4, 4))
    for m, (response, drive) in enumerate(poles(law, data, now, rest)):
        for start in range(0, n_frf, step):
            frfs = slice(start, start + step)
            if known is None:
                errors = _independent(data.weight[m, frfs], whole[m, frfs])
            else:
                errors = _errors(leakage, data, m, frfs, (response, drive), known)
            follow = influence(method, law, data, now, m, frfs) * whole[m, frfs, None]
            out[m, frfs] = errors.propagate(follow)
    return out


def _independent(weight: FloatArray, whole: ComplexArray) -> LineErrors:
    exact = weight * np.abs(whole) ** 2
    variance = np.where(exact > 0, 1 / np.where(exact > 0, exact, 1.0), 0.0)
    covariance = (variance[..., None] * np.eye(variance.shape[-1])).astype(complex)
    return LineErrors(covariance, np.zeros_like(covariance))


def _errors(
    leakage: WindowLeakage,
    data: Data,
    m: int,
    frfs: slice,
    near: tuple[SinglePole, SinglePole],
    known: LineSpectra,
) -> LineErrors:
    freq = data.freq[m, frfs]
    some = (SinglePole(pole.eigenvalue[frfs], pole.constant[frfs], pole.residual[frfs]) for pole in near)
    leaked = leaked_lines(leakage, freq, data.spacing, *some).errors
    covariance, relation = leaked.covariance / known.averages, leaked.relation / known.averages
    own = np.diagonal(covariance, axis1=-2, axis2=-1).real
    more = np.sqrt(np.maximum(known.variance[m, frfs] - own, 0.0))
    noise = more[..., :, None] * more[..., None, :] * white_error_correlation(leakage, freq, data.spacing)
    return LineErrors(covariance + noise, relation)
