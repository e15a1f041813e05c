"""How each response of a measurement differs from its prediction: by a gain, a sign, a delay."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import normalised_difference
from modallab.diagnosis.result import ChannelError, ResponseMisfit

ACCOUNTED = 0.9  # share of a response's gap above 1 that a course closes if it is the reason
DISAGREES = 3.0  # gap from which on it is asked for reasons


def response_misfits(observed: Observed, h: ComplexArray) -> tuple[ResponseMisfit, ...]:
    """Return how every response differs over all usable lines.

    Parameters
    ----------
    h
        (n_freq, n_out), predicted.
    """
    left = normalised_difference(observed, h)
    return tuple(_misfit(observed, left, i) for i in range(len(observed.outputs)))


def _misfit(observed: Observed, left: ComplexArray, channel: int) -> ResponseMisfit:
    where = observed.usable[:, channel]
    error = observed.error[where, channel]
    ratio, omega = left[where, channel] / error, 2 * np.pi * observed.freq[where]
    n = max(len(ratio), 1)
    constant, growing = 1 / error, omega / error
    size, size_error = _along(ratio.real, constant)
    phase, phase_error = _along(ratio.imag, constant)
    delay, delay_error = _along(ratio.imag, -growing)
    gap = float((np.abs(ratio) ** 2).mean() / 2) if len(ratio) else 0.0
    turned = np.angle(np.exp(1j * (left[where, channel].imag - np.pi))) / error
    rising = ratio.real - _along(ratio.real, omega**2 / error)[0] * omega**2 / error
    rest = {
        ChannelError.GAIN: (ratio.real - size * constant, ratio.imag),
        ChannelError.POLARITY: (ratio.real, turned),
        ChannelError.DELAY: (ratio.real, ratio.imag + delay * growing),
        ChannelError.RISING_GAIN: (rising, ratio.imag),
    }
    closed = {c: float((re**2 + im**2).sum()) / (2 * n) for c, (re, im) in rest.items()}
    best = min(closed, key=lambda course: closed[course])
    told = gap > DISAGREES and gap - closed[best] > ACCOUNTED * (gap - 1)
    return ResponseMisfit(
        dof=observed.outputs[channel],
        gap=gap,
        amplitude=float(np.exp(size)),
        amplitude_error=float(np.exp(size) * size_error),
        phase=phase,
        phase_error=phase_error,
        delay=delay,
        delay_error=delay_error,
        course=best if told else None,
    )


def _along(ratio: FloatArray, course: FloatArray) -> tuple[float, float]:
    """Return how much of a course is in a whitened residual, and the standard error of that."""
    known = float(course @ course)
    if not known > 0:
        return 0.0, float("inf")
    best = float(course @ ratio) / known
    scale = max(1.0, float(((ratio - best * course) ** 2).mean()))
    return best, float(np.sqrt(scale / known))
