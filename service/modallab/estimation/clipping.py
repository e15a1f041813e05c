"""Spectra of clipped Gaussian signals: linear gain and distortion."""

from itertools import combinations

import numpy as np
import scipy.fft
from scipy.special import erf

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.settings import CLIPPING
from modallab.estimation.spectra import CrossSpectra


def bussgang_gain(level: FloatArray) -> FloatArray:
    """Return the Bussgang gain of a clipped Gaussian signal, erf(c / sqrt 2), for c in standard deviations.

    Bussgang (1952), MIT Research Laboratory of Electronics, report 216: the output of any memoryless
    element is the input times a gain plus what is uncorrelated with it.
    """
    return np.asarray(erf(level / np.sqrt(2)))


def clipped_power(level: FloatArray) -> FloatArray:
    """Return the mean square of a Gaussian signal of variance 1 clipped at +-level: closed form."""
    inside = erf(level / np.sqrt(2))
    return np.asarray(inside - 2 * level * _density(level) + level**2 * (1 - inside))


def hermite_coefficients(level: FloatArray) -> FloatArray:
    """Return the Hermite coefficients of a clipped Gaussian signal, (n_orders, ...).

    Coefficients -2 phi(c) He_{n-2}(c) / sqrt(n!) of the normalised polynomials of orders
    `CLIPPING.hermite_orders`; those of even orders are 0.
    """
    parts = []
    previous, polynomial = np.zeros_like(level), np.ones_like(level)  # He_n / sqrt(n!)
    for n in range(CLIPPING.hermite_orders[-1] - 1):
        if n + 2 in CLIPPING.hermite_orders:
            parts.append(-2 * _density(level) * polynomial / np.sqrt((n + 1) * (n + 2)))
        previous, polynomial = polynomial, (level * polynomial - np.sqrt(n) * previous) / np.sqrt(n + 1)
    return np.array(parts)


def clipped_spectra(
    spectra: CrossSpectra, level: FloatArray, high_frequency: FloatArray, sample_rate: float
) -> CrossSpectra:
    """Return the spectra of Gaussian signals clipped at +-level.

    Each spectrum times its gains, and the distortion: of the correlation rho of two signals Hermite order n
    leaves rho^n; Price (1958), IRE Trans. Information Theory 4, 69-72. Correlations are those of the samples,
    so that power above half the sample rate is aliased.

    Parameters
    ----------
    level
        (n_run, n_ch) in the unit of each channel, forces first.
    high_frequency
        (n_run, n_ch) flat spectrum of each channel above the last line.
    """
    n_in, n_out = spectra.fx.shape[2:]
    first, second = _pairs(n_in, n_out)
    n_ch, n_lines = n_in + n_out, len(spectra.freq)
    spacing = float(spectra.freq[1] - spectra.freq[0])
    n_samples = max(round(sample_rate / spacing), 2 * n_lines)
    full_band = np.zeros((len(level), n_samples // 2 + 1, len(first)), complex)
    full_band[:, n_lines:, :n_ch] = high_frequency[:, None]
    channel_spectra = _pack(spectra)
    full_band[:, :n_lines] = channel_spectra
    scaling = n_samples * spacing / 2  # one-sided density a line to the two-sided sum over all
    correlation = scaling * scipy.fft.irfft(full_band, n_samples, axis=1)
    size = np.sqrt(np.maximum(correlation[:, 0, :n_ch], np.finfo(float).tiny))
    c = np.minimum(level / size, CLIPPING.max_level)
    scale = size[:, first] * size[:, second]
    correlation /= scale[:, None]
    distortion = scipy.fft.rfft(_distorted(correlation, _weights(c, first, second)), axis=1)[:, :n_lines]
    # Rounding of the FFT, of either sign, may exceed what weak clipping leaves in a line.
    distortion[..., :n_ch] = np.maximum(distortion[..., :n_ch].real, 0.0)
    gain = bussgang_gain(c)
    return _unpack(
        spectra,
        (gain[:, first] * gain[:, second])[:, None] * channel_spectra + scale[:, None] / scaling * distortion,
    )


def _density(level: FloatArray) -> FloatArray:
    return np.asarray(np.exp(-(level**2) / 2) / np.sqrt(2 * np.pi))


def _pairs(n_in: int, n_out: int) -> tuple[list[int], list[int]]:
    """Return the channels of the spectra side by side: autos, between forces, forces to responses."""
    n_ch = n_in + n_out
    between = list(combinations(range(n_in), 2))
    across = [(i, n_in + o) for i in range(n_in) for o in range(n_out)]
    first, second = zip(*[(i, i) for i in range(n_ch)], *between, *across, strict=True)
    return list(first), list(second)


def _pack(spectra: CrossSpectra) -> ComplexArray:
    """Return all spectra stacked along the last axis, (n_run, n_lines, n_pairs)."""
    n_run, n_lines, n_in, _ = spectra.fx.shape
    diagonal, upper = np.arange(n_in), np.triu_indices(n_in, 1)
    parts = [spectra.ff[..., diagonal, diagonal], spectra.xx, spectra.ff[..., *upper], spectra.fx]
    return np.concatenate([part.reshape(n_run, n_lines, -1) for part in parts], axis=2)


def _unpack(spectra: CrossSpectra, pairs: ComplexArray) -> CrossSpectra:
    """Return spectra from the stacked array of `_pack`."""
    n_in, n_out = spectra.fx.shape[2:]
    diagonal, (row, column) = np.arange(n_in), np.triu_indices(n_in, 1)
    edges = np.cumsum([n_in, n_out, len(row)])
    autos, xx, between, fx = np.split(pairs, edges, axis=2)
    ff = np.empty_like(spectra.ff)
    ff[..., diagonal, diagonal] = autos.real
    ff[..., row, column], ff[..., column, row] = between, between.conj()
    return CrossSpectra(spectra.freq, ff, fx.reshape(spectra.fx.shape), xx.real, spectra.averages)


def _weights(c: FloatArray, first: list[int], second: list[int]) -> FloatArray:
    """Return the weights of the Hermite orders of all pairs; the last is the remainder of auto spectra."""
    parts = hermite_coefficients(c)
    remainder = clipped_power(c) - bussgang_gain(c) ** 2 - (parts**2).sum(axis=0)
    last = np.zeros((1, len(c), len(first)))
    last[0, :, : c.shape[1]] = np.maximum(remainder, 0.0)
    return np.concatenate([parts[:, :, first] * parts[:, :, second], last])


def _distorted(correlation: FloatArray, weights: FloatArray) -> FloatArray:
    """Return sum_n weight_n rho^n over odd n from 3, by Horner's rule in rho^2."""
    square = correlation**2
    total = np.zeros_like(correlation)
    for weight in weights[::-1]:
        total += weight[:, None]
        total *= square
    total *= correlation
    return total
