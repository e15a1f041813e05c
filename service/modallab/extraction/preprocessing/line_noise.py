"""How much random error each line of the responses has, as a fit of many modes at once weighs it."""

import numpy as np
import scipy.ndimage

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.preprocessing.responses import Responses

NEIGHBOURS = 33  # lines that residuals are averaged over, where nothing else tells their variance
ROUGH = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / np.sqrt(70.0)  # leaves noise as it is, and no cubic
QUIET = 0.25  # of the lines: so many at least are rough by noise alone
ROUNDING = 1e-16  # of |H|^2: what a transform leaves in any case


def knows_noise(responses: Responses) -> bool:
    """Return whether coherence tells the random error; it does not where it is 1 throughout."""
    return bool((responses.coherence < 1).any())


def line_weights(responses: Responses, bias: FloatArray | float = 0.0) -> FloatArray:
    """Return one over E|error|^2 of receptance, (n_freq, n_frf); 0 where nothing is coherent.

    A coherence estimated from n averages says on average (n - 2)/n of the error there is. Where none was
    measured, the error is taken for the same at all lines of an FRF's mobility, and to be what makes
    its quieter lines rough.

    Parameters
    ----------
    bias
        (n_freq, n_frf), relative, that lines may have beside their random error. It does not fall with
        averages, so that lines of low coherence, as at antiresonances, could mislead a fit of all lines.
    """
    if not knows_noise(responses):
        omega = 2 * np.pi * responses.freq[:, None]
        noise = _roughness(omega * responses.receptance)
        return np.asarray(omega**2 * np.where(noise > 0, 1 / np.where(noise > 0, noise, 1.0), 0.0))
    n = responses.averages
    low = n / (n - 2) if n > 3 else 1.0
    variance = responses.variance * low + (bias * np.abs(responses.receptance)) ** 2
    usable = np.isfinite(variance) & (variance > 0)
    return np.where(usable, 1 / np.where(usable, variance, 1.0), 0.0)


def _roughness(values: ComplexArray) -> FloatArray:
    """Return E|error|^2 of each FRF (n_frf,), from differences of its lines.

    Of one that is zero it is that of the least exact other: a dead channel must not count as exact.
    """
    rough = scipy.ndimage.convolve1d(values, ROUGH, axis=0, mode="nearest")
    power = np.quantile(np.abs(rough) ** 2, QUIET, axis=0) / -np.log1p(-QUIET)  # of an exponential law
    noise = power + ROUNDING * (np.abs(values) ** 2).mean(axis=0)
    return np.asarray(np.where(noise > 0, noise, noise.max(initial=0.0)))


def weights_from_residuals(receptance: ComplexArray, fitted: ComplexArray, weight: FloatArray) -> FloatArray:
    """Return one over E|error|^2 as the residuals of a fit near each line have it.

    Parameters
    ----------
    receptance, fitted, weight
        (n_lines, n_frf); lines of weight 0 stay so and do not count.
    """
    used = (weight > 0).astype(float)
    power = np.abs(receptance - fitted) ** 2 * used
    width = min(NEIGHBOURS, len(power))
    near, count = (
        scipy.ndimage.uniform_filter1d(values, width, axis=0, mode="nearest") for values in (power, used)
    )
    largest = np.abs(fitted).max(axis=1, keepdims=True, initial=0.0)
    variance = near / np.maximum(count, 1 / width) + ROUNDING * largest**2
    usable = (used > 0) & (variance > 0)
    return np.where(usable, 1 / np.where(usable, variance, 1.0), 0.0)
