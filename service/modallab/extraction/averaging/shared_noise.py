"""Correlation of the random errors of different FRFs."""

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.extraction.averaging.settings import SHARED_NOISE
from modallab.extraction.preprocessing.noise_ratios import NoiseToSignal
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fit_data import FitData
from modallab.extraction.single_mode.fit_table import ConvergedFits
from modallab.extraction.single_mode.settings import SINGLE_MODE_FIT


def shared_noise_fraction(
    damping_model: DampingModel,
    data: FitData,
    settled: ConvergedFits,
    index: IntArray,
    noise: NoiseToSignal | None = None,
) -> FloatArray:
    """Return the correlation of the errors of different FRFs near each resonance, (n_modes,) 0 to 1.

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
    noise
        Of force and responses, whose ratio the correlations of different modes have; None: the correlation
        is the same for all modes.
    """
    error, used, size = _relative_errors(damping_model, data, settled)
    by_force = np.ones(len(index)) if noise is None else _force_share(noise, index, size)
    cross_product, norm_product, count = 0.0, 0.0, 0.0
    for m, (mode_error, mode_used, line) in enumerate(zip(error, used, index, strict=True)):
        row, column = np.nonzero(mode_used)
        if not len(row):
            continue
        position = line[row, column] - line.min()
        dense = np.zeros((len(mode_used), position.max() + 1), complex)
        present = np.zeros(dense.shape)
        dense[row, position], present[row, position] = mode_error[row, column], 1.0
        if settled.remaining_noise is not None:  # no more than noise: a misfit differs from FRF to FRF
            excess = (np.abs(dense) ** 2).sum(axis=1) / np.maximum(settled.remaining_noise[m], SAFE_DIVISOR)
            dense /= np.sqrt(np.maximum(excess, 1.0))[:, None]
        power = (np.abs(dense) ** 2) @ present.T  # of each FRF at the lines of another
        pairs = ~np.eye(len(mode_used), dtype=bool)
        cross_product += by_force[m] * float((dense @ dense.conj().T).real[pairs].sum())
        norm_product += by_force[m] ** 2 * float(np.sqrt(power * power.T)[pairs].sum())
        count += float((present @ present.T)[pairs].sum()) / 2
    if not (norm_product > 0 and count >= SHARED_NOISE.minimum_pairs):
        return np.zeros(len(index))
    return np.asarray(np.clip(cross_product / norm_product, 0.0, 1.0) * by_force)


def _force_share(noise: NoiseToSignal, index: IntArray, size: FloatArray) -> FloatArray:
    """Return the part of the error near each resonance by noise of the force, (n_modes,)."""
    share = noise.force_share[index, np.arange(index.shape[1])[None, :, None]]
    weight = size**2
    total = weight.sum(axis=2)
    by_frf = (weight * share).sum(axis=2) / np.where(total > 0, total, 1.0)
    shown = total > 0
    return np.asarray((by_frf * shown).sum(axis=1) / np.maximum(shown.sum(axis=1), 1))


def _relative_errors(
    damping_model: DampingModel, data: FitData, settled: ConvergedFits
) -> tuple[ComplexArray, BoolArray, FloatArray]:
    """Return the errors of the lines, their use, and the modulus of the mode, (n_modes, n_frf, n_lines)."""
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
    used = weight > 0
    return error, used, np.where(used, size, 0.0)
