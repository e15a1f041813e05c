"""Variance of the random error of each line, as the weights of multi-mode fits."""

import numpy as np
import scipy

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import SAFE_DIVISOR, SQUARE_ROUNDING
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

    Without a measured coherence the error variance is taken as constant over the lines of each FRF, in the
    kind of FRF whose noise is white, and is estimated from the fourth differences of its quieter lines.

    Parameters
    ----------
    responses
        From `responses_of`.
    bias
        (n_freq, n_frf) relative bias of the lines in addition to their random error. It does not fall with
        the number of averages, so that lines of low coherence, as at antiresonances, could mislead a fit.
    """
    if not has_coherence(responses):
        scale = _white_noise_scale(responses)
        noise = _noise_from_differences(scale * responses.receptance)
        return np.asarray(scale**2 * np.where(noise > 0, 1 / np.where(noise > 0, noise, 1.0), 0.0))
    correction = coherence_correction(responses.averages)
    variance = responses.variance * correction + (bias * np.abs(responses.receptance)) ** 2
    usable = np.isfinite(variance) & (variance > 0)
    return np.where(usable, 1 / np.where(usable, variance, 1.0), 0.0)


def _white_noise_scale(responses: Responses) -> FloatArray:
    """Return the factor from receptance to the kind of FRF with white noise, (n_freq, 1); mobility if none.

    Noise is white where the fourth differences of the quieter lines are alike in all parts of the range.
    """
    omega = 2 * np.pi * responses.freq[:, None]
    scales = (omega, omega**2, np.ones_like(omega))
    scatter = [_level_scatter(scale * responses.receptance) for scale in scales]
    whitest = int(np.argmin(scatter))
    return scales[whitest if scatter[whitest] < LINE_NOISE.largest_level_scatter else 0]


def _level_scatter(values: ComplexArray) -> float:
    """Return the standard deviation over parts of the range of ln E|error|^2, the median of the FRFs."""
    parts = np.array_split(np.abs(_differences(values)) ** 2, LINE_NOISE.parts)
    level = np.array([np.quantile(part, LINE_NOISE.quiet_fraction, axis=0) for part in parts])
    return float(np.median(np.log(np.maximum(level, SAFE_DIVISOR)), axis=1).std())


def _differences(values: ComplexArray) -> ComplexArray:
    return np.asarray(scipy.ndimage.convolve1d(values, FOURTH_DIFFERENCE, axis=0, mode="nearest"))


def _noise_from_differences(values: ComplexArray) -> FloatArray:
    """Return E|error|^2 of each FRF from fourth differences of its lines, (n_frf,).

    An FRF of zeros has the largest variance of the others: a dead channel must not count as exact.
    """
    power = np.quantile(np.abs(_differences(values)) ** 2, LINE_NOISE.quiet_fraction, axis=0) / -np.log1p(
        -LINE_NOISE.quiet_fraction
    )  # quantile of an exponential distribution
    noise = power + SQUARE_ROUNDING * (np.abs(values) ** 2).mean(axis=0)
    return np.asarray(np.where(noise > 0, noise, noise.max(initial=0.0)))


def weights_from_residuals(receptance: ComplexArray, fitted: ComplexArray, weight: FloatArray) -> FloatArray:
    """Return the weights 1/E|error|^2 from the squared residuals of a fit, (n_lines, n_frf).

    Present weights are scaled by one factor for each FRF and group of adjacent lines.

    Parameters
    ----------
    receptance, fitted, weight
        (n_lines, n_frf) measured and fitted receptance, m/N, and present weights; weights of 0 remain 0.
    """
    n_lines = len(weight)
    start = np.arange(max(n_lines // LINE_NOISE.neighbours, 1)) * LINE_NOISE.neighbours
    size = np.diff(np.append(start, n_lines))
    used = weight > 0
    largest = np.abs(fitted).max(axis=1, keepdims=True, initial=0.0)
    power = np.where(used, np.abs(receptance - fitted) ** 2 + SQUARE_ROUNDING * largest**2, 0.0)
    count = np.add.reduceat(used.astype(int), start)
    ratio = np.add.reduceat(power * weight, start) / np.maximum(count, 1)
    factor = np.where(ratio > 0, 1 / np.where(ratio > 0, ratio, 1.0), 0.0)
    return np.asarray(weight * factor.repeat(size, axis=0))
