"""Flags on modes whose lines or band contain more than one mode."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.modal_model import ModalModel, Mode
from modallab.extraction.averaging.settings import MISFIT
from modallab.extraction.preprocessing.bands import Band
from modallab.extraction.preprocessing.fit_windows import without_nearest
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.preprocessing.settings import BANDS
from modallab.extraction.single_mode.damping_models import DampingModel


def flag_misfits(
    model: ModalModel, responses: Responses, damping_model: DampingModel, leave_out: int
) -> ModalModel:
    """Return the model with the flag `misfit` at every mode that one mode does not explain.

    All modes, each with the pole of the FRF, and a mass-like and a stiffness-like residual are subtracted
    from the lines of each fit. The remainder beyond random error is compared with the response of the mode,
    as a median over the FRFs.

    Parameters
    ----------
    model
        With the lines of its fits; from records without leakage.
    responses
        FRFs of the fits.
    damping_model
        Damping model.
    leave_out
        Number of lines nearest to resonance that the fits left out.
    """
    if model.fitted_lines is None:
        return model
    misfit = _relative_misfit(model, responses, damping_model, leave_out)
    modes = tuple(_flagged(mode, float(share)) for mode, share in zip(model.modes, misfit, strict=True))
    return replace(model, modes=modes)


def flag_further_peaks(
    model: ModalModel, freq: FloatArray, indicator: FloatArray, bands: Sequence[Band]
) -> ModalModel:
    """Return the model with the flag `further peak` at every mode whose band has several peaks.

    Parameters
    ----------
    model
        Modes of the bands.
    freq, indicator
        (n_freq,) Hz, and from `mode_indicator`.
    bands
        Bands that the user requested, each with the peak of its mode.
    """
    modes = list(model.modes)
    for band in bands:
        flag = _further_peaks(freq, indicator, band)
        lower, upper = freq[band.first], freq[band.last]
        for i, mode in enumerate(modes):
            if flag and lower <= mode.frequency <= upper:
                modes[i] = replace(mode, flags=(*mode.flags, flag))
    return replace(model, modes=tuple(modes))


def _further_peaks(freq: FloatArray, indicator: FloatArray, band: Band) -> str:
    level = np.log10(indicator[band.first : band.last + 1])
    peaks = band.first + scipy.signal.find_peaks(level, prominence=BANDS.prominence)[0]
    further_peaks = [f"{freq[peak]:g}" for peak in peaks if peak != band.peak]
    return f"further peak: at {', '.join(further_peaks)} Hz in the same band" if further_peaks else ""


def _flagged(mode: Mode, share: float) -> Mode:
    if not share > MISFIT.largest_misfit:
        return mode
    flag = f"misfit: one mode leaves {share:.0%} of its lines unexplained; there may be several modes"
    return replace(mode, flags=(*mode.flags, flag))


def _relative_misfit(
    model: ModalModel, responses: Responses, damping_model: DampingModel, leave_out: int
) -> FloatArray:
    """Return the remainder of each mode's lines relative to its response, (n_modes,)."""
    lines, fitted = np.asarray(model.fitted_lines), np.asarray(model.fitted_frequency)
    offset = np.arange(int((lines[:, :, 1] - lines[:, :, 0]).max()) + 1)
    index = lines[:, :, :1] + offset
    used = index <= lines[:, :, 1:]
    index = np.minimum(index, len(responses.freq) - 1)
    column = np.arange(fitted.shape[1])[None, :, None]
    variance = responses.variance[index, column]
    used &= np.isfinite(variance)
    freq, identified = responses.freq[index], np.isfinite(fitted)
    remainder = responses.receptance[index, column]
    used = without_nearest(freq * np.abs(remainder), used, leave_out)
    pole, constant = _poles(model), np.asarray(model.modal_constant)
    modes = damping_model.response(freq, pole[:, :, None], constant[:, :, None])
    for m in range(
        len(pole)
    ):  # all in one array would need memory proportional to the squared number of modes
        remainder = remainder - damping_model.response(freq, pole[m][:, None], constant[m][:, None])
    power = (np.abs(_without_residuals(remainder * used, freq, used)) ** 2 * used).sum(axis=2)
    random = np.where(used, variance, 0.0).sum(axis=2)
    size = (np.abs(modes) ** 2 * used).sum(axis=2)
    share = np.sqrt(np.maximum(power - random, 0.0) / np.where(size > 0, size, np.inf))
    return np.array(
        [
            np.median(row[identified_frfs]) if identified_frfs.any() else 0.0
            for row, identified_frfs in zip(share, identified, strict=True)
        ]
    )


def _poles(model: ModalModel) -> ComplexArray:
    """Return omega_r^2 (1 + i eta_r) of each fit, that of the mean mode where an FRF has no fit."""
    common = np.array([[mode.frequency, mode.loss_factor] for mode in model.modes])[:, :, None]
    frequency, loss_factor = np.asarray(model.fitted_frequency), np.asarray(model.fitted_loss_factor)
    frequency = np.where(np.isfinite(frequency), frequency, common[:, 0])
    loss_factor = np.where(np.isfinite(loss_factor), loss_factor, common[:, 1])
    return np.asarray((2 * np.pi * frequency) ** 2 * (1 + 1j * loss_factor))


def _without_residuals(remainder: ComplexArray, freq: FloatArray, used: BoolArray) -> ComplexArray:
    """Return the remainder without a constant and a multiple of one over squared frequency, row by row."""
    middle = freq.mean(axis=2, keepdims=True)
    basis = np.stack([used, used * (middle / freq) ** 2], axis=-1)
    coefficients = np.linalg.pinv(basis) @ remainder[..., None]
    return np.asarray(remainder - (basis @ coefficients)[..., 0])
