"""Bias of fits by residuals that are not constant over a window."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fit_data import FitData
from modallab.extraction.single_mode.fit_table import ConvergedFits, FitIteration
from modallab.extraction.single_mode.fitting import fit_once
from modallab.extraction.single_mode.method import ExtractionMethod
from modallab.extraction.single_mode.settings import RESIDUAL_BIAS, SINGLE_MODE_FIT


def residual_shift(
    method: ExtractionMethod,
    damping_model: DampingModel,
    data: FitData,
    settled: ConvergedFits,
    fits: FitIteration,
) -> FloatArray:
    """Return the change of the fits if the residual may vary over the lines, (n_modes, n_frf, 4).

    Columns are real and imaginary part of the eigenvalue, (rad/s)^2, and of the modal constant, 1/kg. A
    mass-like and a stiffness-like term are fitted, for each FRF, to the lines without all modes, and
    subtracted: the fits themselves allow only for a constant in each window. Zeros if there are too few
    modes.

    Parameters
    ----------
    method, damping_model, data, settled
        As in `fit_all`, and its result.
    fits
        Fits to the cleaned lines.
    """
    if len(data.freq) < RESIDUAL_BIAS.minimum_modes:
        return np.zeros((*data.freq.shape[:2], 4))
    modes = damping_model.response(
        data.freq, fits.eigenvalue[..., None], fits.table.modal_constant[..., None]
    )
    residual = _two_terms(data, settled.cleaned - modes)
    refitted = fit_once(method, damping_model, data, settled.cleaned - residual, settled.inertance)
    identified = (fits.table.frequency > 0) & (refitted.table.frequency > 0)
    pole = np.where(identified, refitted.eigenvalue - fits.eigenvalue, 0)
    constant = np.where(identified, refitted.table.modal_constant - fits.table.modal_constant, 0)
    return np.stack([pole.real, pole.imag, constant.real, constant.imag], axis=-1)


def _two_terms(data: FitData, remainder: ComplexArray) -> ComplexArray:
    """Return the sum of a constant and a multiple of 1/omega^2 nearest to the remainder of each FRF."""
    inverse = data.x.mean() / np.maximum(data.x, SINGLE_MODE_FIT.smallest_eigenvalue)
    columns = np.stack([np.ones_like(inverse), inverse], axis=-1)
    weight = data.weight[..., None] * columns
    normal = np.einsum("mjkp,mjkq->jpq", weight, columns)
    products = np.einsum("mjkp,mjk->jp", weight, remainder)
    terms = np.linalg.pinv(normal, hermitian=True) @ products[..., None]
    return np.asarray((columns @ terms[None])[..., 0])
