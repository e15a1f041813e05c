"""Whether one mode is all there is in the lines that a single-mode fit drew on, and in its band."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy.signal

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.modal_model import ModalModel, Mode
from modallab.extraction.preprocessing.bands import Band
from modallab.extraction.preprocessing.fit_windows import without_nearest
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.preprocessing.settings import BANDS
from modallab.extraction.single_mode.damping_models import DampingModel

MUCH = 0.1  # of a mode's own response: noise of 5 % leaves half of it, two modes in a bandwidth leave more


def flag_misfits(model: ModalModel, responses: Responses, law: DampingModel, leave_out: int) -> ModalModel:
    """Return the model with the flag `misfit` at every mode that one mode does not explain.

    From the lines of each fit all modes are taken off, each with the FRF's own pole, then a mass-like and a
    stiffness-like residual. What is left beyond random error is compared with the mode's own response; the
    middle one of the FRFs speaks for all.

    Parameters
    ----------
    model
        With the lines that its fits drew on; of records that do not leak.
    responses
        What it was read from.
    law
        What its damping does.
    leave_out
        How many lines nearest resonance the fits left out.
    """
    if model.fitted_lines is None:
        return model
    left = _left(model, responses, law, leave_out)
    modes = tuple(_flagged(mode, float(share)) for mode, share in zip(model.modes, left, strict=True))
    return replace(model, modes=modes)


def flag_further_peaks(
    model: ModalModel, freq: FloatArray, indicator: FloatArray, bands: Sequence[Band]
) -> ModalModel:
    """Return the model with the flag `further peak` at every mode whose band holds more peaks than its own.

    Parameters
    ----------
    freq, indicator
        (n_freq,) Hz and from `mode_indicator`.
    bands
        Those that the user gave, with the peak that was taken for the mode's.
    """
    modes = list(model.modes)
    for band in bands:
        told = _further(freq, indicator, band)
        lower, upper = freq[band.first], freq[band.last]
        for i, mode in enumerate(modes):
            if told and lower <= mode.frequency <= upper:
                modes[i] = replace(mode, flags=(*mode.flags, told))
    return replace(model, modes=tuple(modes))


def _further(freq: FloatArray, indicator: FloatArray, band: Band) -> str:
    level = np.log10(indicator[band.first : band.last + 1])
    peaks = band.first + scipy.signal.find_peaks(level, prominence=BANDS.prominence)[0]
    others = [f"{freq[peak]:g}" for peak in peaks if peak != band.peak]
    return f"further peak: at {', '.join(others)} Hz in the same band" if others else ""


def _flagged(mode: Mode, share: float) -> Mode:
    if not share > MUCH:
        return mode
    told = f"misfit: one mode leaves {share:.0%} of its lines unexplained, two modes or more may be there"
    return replace(mode, flags=(*mode.flags, told))


def _left(model: ModalModel, responses: Responses, law: DampingModel, leave_out: int) -> FloatArray:
    """Return what is left of each mode's lines, relative to its own response, (n_modes,)."""
    lines, fitted = np.asarray(model.fitted_lines), np.asarray(model.fitted_frequency)
    offset = np.arange(int((lines[:, :, 1] - lines[:, :, 0]).max()) + 1)
    index = lines[:, :, :1] + offset
    used = index <= lines[:, :, 1:]
    index = np.minimum(index, len(responses.freq) - 1)
    column = np.arange(fitted.shape[1])[None, :, None]
    variance = responses.variance[index, column]
    used &= np.isfinite(variance)
    freq, seen = responses.freq[index], np.isfinite(fitted)
    rest = responses.receptance[index, column]
    used = without_nearest(freq * np.abs(rest), used, leave_out)
    pole, constant = _poles(model), np.asarray(model.modal_constant)
    own = law.response(freq, pole[:, :, None], constant[:, :, None])
    for m in range(len(pole)):  # all at once would be the square of the modes in memory
        rest = rest - law.response(freq, pole[m][:, None], constant[m][:, None])
    power = (np.abs(_without_residuals(rest * used, freq, used)) ** 2 * used).sum(axis=2)
    random = np.where(used, variance, 0.0).sum(axis=2)
    size = (np.abs(own) ** 2 * used).sum(axis=2)
    share = np.sqrt(np.maximum(power - random, 0.0) / np.where(size > 0, size, np.inf))
    return np.array(
        [np.median(row[shown]) if shown.any() else 0.0 for row, shown in zip(share, seen, strict=True)]
    )


def _poles(model: ModalModel) -> ComplexArray:
    """Return omega_r^2 (1 + i eta_r) of each fit, the mode's own where an FRF does not show it."""
    common = np.array([[mode.frequency, mode.loss_factor] for mode in model.modes])[:, :, None]
    frequency, loss_factor = np.asarray(model.fitted_frequency), np.asarray(model.fitted_loss_factor)
    frequency = np.where(np.isfinite(frequency), frequency, common[:, 0])
    loss_factor = np.where(np.isfinite(loss_factor), loss_factor, common[:, 1])
    return np.asarray((2 * np.pi * frequency) ** 2 * (1 + 1j * loss_factor))


def _without_residuals(rest: ComplexArray, freq: FloatArray, used: BoolArray) -> ComplexArray:
    """Return what a constant and one over frequency squared do not explain, each row by itself."""
    middle = freq.mean(axis=2, keepdims=True)
    basis = np.stack([used, used * (middle / freq) ** 2], axis=-1)
    found = np.linalg.pinv(basis) @ rest[..., None]
    return np.asarray(rest - (basis @ found)[..., 0])
