"""Deviation of each measured FRF from its prediction: amplitude, phase, delay, channel error."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.diagnosis.localisation.settings import CHANNEL_ERRORS
from modallab.diagnosis.residuals.normalised_difference import normalised_difference
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.result_localisation import ChannelError, ResponseMisfit


def response_misfits(observed: Observed, h: ComplexArray) -> tuple[ResponseMisfit, ...]:
    """Return the deviation of each FRF over all usable lines.

    Parameters
    ----------
    h
        (n_freq, n_out), predicted FRFs.
    """
    difference = normalised_difference(observed, h)
    return tuple(_misfit(observed, difference, i) for i in range(len(observed.outputs)))


def _misfit(observed: Observed, difference: ComplexArray, channel: int) -> ResponseMisfit:
    """Return the deviation of one FRF: weighted regressions of log magnitude and phase on frequency."""
    usable = observed.usable[:, channel]
    error, log_ratio = observed.error[usable, channel], difference[usable, channel]
    residual, omega = log_ratio / error, 2 * np.pi * observed.freq[usable]
    log_amplitude, log_amplitude_error = _regression(residual.real, 1 / error)
    phase, phase_error = _regression(residual.imag, 1 / error)
    delay, delay_error = _regression(residual.imag, -omega / error)
    gap = float((np.abs(residual) ** 2).mean() / 2) if len(residual) else 0.0
    return ResponseMisfit(
        dof=observed.channels[channel].response,
        drive=observed.channels[channel].drive,
        gap=gap,
        amplitude=float(np.exp(log_amplitude)),
        amplitude_error=float(np.exp(log_amplitude) * log_amplitude_error),
        phase=phase,
        phase_error=phase_error,
        delay=delay,
        delay_error=delay_error,
        course=_channel_error(log_ratio, error, omega, gap),
    )


def _channel_error(
    log_ratio: ComplexArray, error: FloatArray, omega: FloatArray, gap: float
) -> ChannelError | None:
    """Return the channel error that accounts for nearly all of the gap; None if no single one does."""
    residual = log_ratio / error
    gain, _ = _regression(residual.real, 1 / error)
    delay, _ = _regression(residual.imag, -omega / error)
    rise, _ = _regression(residual.real, omega**2 / error)
    inverted_phase = np.angle(np.exp(1j * (log_ratio.imag - np.pi))) / error
    remainders = {
        ChannelError.GAIN: (residual.real - gain / error, residual.imag),
        ChannelError.POLARITY: (residual.real, inverted_phase),
        ChannelError.DELAY: (residual.real, residual.imag + delay * omega / error),
        ChannelError.RISING_GAIN: (residual.real - rise * omega**2 / error, residual.imag),
    }
    n = max(len(residual), 1)
    gaps = {kind: float((re**2 + im**2).sum()) / (2 * n) for kind, (re, im) in remainders.items()}
    best = min(gaps, key=lambda kind: gaps[kind])
    explained = gap - gaps[best] > CHANNEL_ERRORS.explained_share * (gap - 1)
    return best if gap > CHANNEL_ERRORS.disagreement and explained else None


def _regression(residual: FloatArray, regressor: FloatArray) -> tuple[float, float]:
    """Return the coefficient of a regressor in a whitened residual, and its standard error."""
    norm = float(regressor @ regressor)
    if not norm > 0:
        return 0.0, float("inf")
    coefficient = float(regressor @ residual) / norm
    scale = max(1.0, float(((residual - coefficient * regressor) ** 2).mean()))
    return coefficient, float(np.sqrt(scale / norm))
