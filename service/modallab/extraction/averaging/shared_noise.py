"""Correlation of the random errors of different FRFs."""

import numpy as np

from modallab.core.arrays import IntArray
from modallab.extraction.averaging.settings import SHARED_NOISE
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fit_data import FitData
from modallab.extraction.single_mode.fit_table import ConvergedFits
from modallab.extraction.single_mode.settings import SINGLE_MODE_FIT


def shared_noise_fraction(
    damping_model: DampingModel, data: FitData, settled: ConvergedFits, index: IntArray
) -> float:
    """Return the correlation of the errors of different FRFs near resonances, 0 to 1.

    Responses recorded simultaneously are divided by the same force, whose noise shifts a mode by the same
    amount in all of them: it does not decrease in the mean over FRFs. Errors are the remainders of the fits
    relative to the response of the mode, because a relative error of the force changes all FRFs by the same
    factor. Records taken one after another have no such correlation.

    Parameters
    ----------
    damping_model
        Damping model.
    data, settled
        Lines of every fit, and the converged fits.
    index
        (n_modes, n_frf, n_lines) index of each line on the frequency axis.
    """
    table = settled.table
    eigenvalue = (2 * np.pi * table.frequency) ** 2 * (1 + 1j * table.loss_factor)
    good = table.screening.good & (eigenvalue.real > 0)
    mode = damping_model.response(
        data.freq,
        np.where(good, eigenvalue, 1 + 1j)[:, :, None],
        np.where(good, table.modal_constant, 1.0)[:, :, None],
    )
    factor = np.where(
        settled.inertance[:, None, None], np.maximum(data.x, SINGLE_MODE_FIT.smallest_eigenvalue), 1.0
    )
    weight = np.where(good[:, :, None], data.weight / factor**2, 0.0)
    remainder = factor * (settled.cleaned - mode)
    total = weight.sum(axis=2, keepdims=True)
    remainder = remainder - (weight * remainder).sum(axis=2, keepdims=True) / np.where(total > 0, total, 1.0)
    size = np.abs(mode)
    error = np.sqrt(weight) * remainder * mode.conj() / np.where(size > 0, size, 1.0)
    cross_product, norm_product, count = 0.0, 0.0, 0.0
    for mode_error, used, line in zip(error, weight > 0, index, strict=True):
        row, column = np.nonzero(used)
        if not len(row):
            continue
        position = line[row, column] - line.min()
        dense = np.zeros((len(used), position.max() + 1), complex)
        present = np.zeros(dense.shape)
        dense[row, position], present[row, position] = mode_error[row, column], 1.0
        power = (np.abs(dense) ** 2) @ present.T  # of each FRF at the lines of another
        pairs = ~np.eye(len(used), dtype=bool)
        cross_product += float((dense @ dense.conj().T).real[pairs].sum())
        norm_product += float(np.sqrt(power * power.T)[pairs].sum())
        count += float((present @ present.T)[pairs].sum()) / 2
    return (
        float(np.clip(cross_product / norm_product, 0.0, 1.0))
        if norm_product > 0 and count >= SHARED_NOISE.minimum_pairs
        else 0.0
    )
