"""Variance of the random error of each line, as the weights of multi-mode fits."""

import numpy as np
import scipy.ndimage

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import SQUARE_ROUNDING
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.preprocessing.settings import LINE_NOISE

# The binomial coefficients' squares sum to 70: white noise keeps its variance, a cubic becomes zero.
FOURTH_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / np.sqrt(70.0)


def has_coherence(responses: Responses) -> bool:
    """Return whether a coherence was measured, so that it gives the random error: it is not 1 everywhere."""
    return bool((responses.coherence < 1).any())


def coherence_correction(averages: float) -> float:
    """Return the ratio of the error variance to the mean of its estimate from coherence, `n/(n - 2)`.

    The coherence of n averages is biased upwards: on average it shows (n - 2)/n of the variance.
    """
    return averages / (averages - 2) if averages > LINE_NOISE.minimum_averages else 1.0


def line_weights(responses: Responses, bias: FloatArray | float = 0.0) -> FloatArray:
    """Return the weights 1/E|error|^2 of receptance, (n_freq, n_frf), (N/m)^2; 0 where nothing is coherent.

    Without a measured coherence the error variance is taken as constant over the lines of each FRF's
    mobility, and is estimated from the fourth differences of its quieter lines.

    Parameters
    ----------
    responses
        From `responses_of`.
    bias
        (n_freq, n_frf) relative bias of the lines in addition to their random error. It does not fall with
        the number of averages, so that lines of low coherence, as at antiresonances, could mislead a fit.
    """
    if not has_coherence(responses):
        omega = 2 * np.pi * responses.freq[:, None]
        noise = _noise_from_differences(omega * responses.receptance)
        return np.asarray(omega**2 * np.where(noise > 0, 1 / np.where(noise > 0, noise, 1.0), 0.0))
    correction = coherence_correction(responses.averages)
    variance = responses.variance * correction + (bias * np.abs(responses.receptance)) ** 2
    usable = np.isfinite(variance) & (variance > 0)
    return np.where(usable, 1 / np.where(usable, variance, 1.0), 0.0)


def _noise_from_differences(values: ComplexArray) -> FloatArray:
    """Return E|error|^2 of each FRF from fourth differences of its lines, (n_frf,).

    An FRF of zeros has the largest variance of the others: a dead channel must not count as exact.
    """
    differences = scipy.ndimage.convolve1d(values, FOURTH_DIFFERENCE, axis=0, mode="nearest")
    power = np.quantile(np.abs(differences) ** 2, LINE_NOISE.quiet_fraction, axis=0) / -np.log1p(
        -LINE_NOISE.quiet_fraction
    )  # quantile of an exponential distribution
    noise = power + SQUARE_ROUNDING * (np.abs(values) ** 2).mean(axis=0)
    return np.asarray(np.where(noise > 0, noise, noise.max(initial=0.0)))


def weights_from_residuals(receptance: ComplexArray, fitted: ComplexArray, weight: FloatArray) -> FloatArray:
    """Return the weights 1/E|error|^2 from the squared residuals of a fit near each line, (n_lines, n_frf).

    Parameters
    ----------
    receptance, fitted, weight
        (n_lines, n_frf) measured and fitted receptance, m/N, and present weights; weights of 0 remain 0.
    """
    used = (weight > 0).astype(float)
    power = np.abs(receptance - fitted) ** 2 * used
    width = min(LINE_NOISE.neighbours, len(power))
    local_power, count = (
        scipy.ndimage.uniform_filter1d(values, width, axis=0, mode="nearest") for values in (power, used)
    )
    largest = np.abs(fitted).max(axis=1, keepdims=True, initial=0.0)
    variance = local_power / np.maximum(count, 1 / width) + SQUARE_ROUNDING * largest**2
    usable = (used > 0) & (variance > 0)
    return np.where(usable, 1 / np.where(usable, variance, 1.0), 0.0)
