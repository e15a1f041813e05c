"""How far a fit is off because what lies outside the range is no constant over its lines."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fitting import TINY, Data, Round, Settled, fit_once
from modallab.extraction.single_mode.method import ExtractionMethod

MODES = 3  # two terms go through what is left at two modes, whatever it is


def moved_by_rest(
    method: ExtractionMethod, law: DampingModel, data: Data, settled: Settled, now: Round
) -> FloatArray:
    """Return by what fits change once the rest may, (n_modes, n_frf, 4).

    Real and imaginary part of the eigenvalue, (rad/s)^2, and of the modal constant, 1/kg. What all modes
    leave of the lines is fitted, FRF by FRF, with a mass-like and a stiffness-like term, which are then taken
    off the lines: a constant in each window is all that the fits themselves allow for. Nothing where modes
    are so few that they do not tell.

    Parameters
    ----------
    method, law, data, settled
        As of `fit_all`, and what it returned.
    now
        Fits to the lines as they were left.
    """
    if len(data.freq) < MODES:
        return np.zeros((*data.freq.shape[:2], 4))
    own = law.response(data.freq, now.eigenvalue[..., None], now.table.modal_constant[..., None])
    rest = _two_terms(data, settled.cleaned - own)
    moved = fit_once(method, law, data, settled.cleaned - rest, settled.inertance)
    found = (now.table.frequency > 0) & (moved.table.frequency > 0)
    pole = np.where(found, moved.eigenvalue - now.eigenvalue, 0)
    constant = np.where(found, moved.table.modal_constant - now.table.modal_constant, 0)
    return np.stack([pole.real, pole.imag, constant.real, constant.imag], axis=-1)


def _two_terms(data: Data, left: ComplexArray) -> ComplexArray:
    """Return the sum of a constant and one over omega^2 nearest to what is left in each FRF, as `left`."""
    inverse = data.x.mean() / np.maximum(data.x, TINY)
    columns = np.stack([np.ones_like(inverse), inverse], axis=-1)
    weight = data.weight[..., None] * columns
    normal = np.einsum("mjkp,mjkq->jpq", weight, columns)
    right = np.einsum("mjkp,mjk->jp", weight, left)
    terms = np.linalg.pinv(normal, hermitian=True) @ right[..., None]
    return np.asarray((columns @ terms[None])[..., 0])
