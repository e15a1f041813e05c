"""Correlation of residuals over lines and channels."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import SAFE_DIVISOR


def dependent_channels(part: ComplexArray | FloatArray) -> float:
    """Return the number of channels per independent channel: noise of a force is in all of its run."""
    products = np.einsum("fi,fj->ij", part.conj(), part)
    size = np.sqrt(np.maximum(products.diagonal().real, SAFE_DIVISOR))
    by_chance = 1 / max(len(part), 1)
    coherence = np.abs(products / np.outer(size, size)) ** 2 - by_chance
    np.fill_diagonal(coherence, 1.0)
    return float(np.maximum(coherence, 0.0).sum() / len(coherence))


def autocovariance(part: ComplexArray | FloatArray) -> ComplexArray:
    """Return the sums of products of residuals (n_freq, n) at every lag in lines, (n_freq,)."""
    spectrum = np.fft.fft(part, 2 * len(part), axis=0)
    return np.asarray(np.fft.ifft((np.abs(spectrum) ** 2).sum(axis=1))[: len(part)])


def correlation_length(part: ComplexArray | FloatArray, max_lag: int | None) -> float:
    """Return the lines per independent line: 1 + 2 sum (1 - k/n) |rho_k|^2 over the lags k."""
    n = len(part)
    covariance = autocovariance(part)
    pairs = 1 - np.arange(1, n) / n  # of n lines only n - k pairs are k apart
    rho = np.abs(covariance[1:]) / max(float(np.abs(covariance[0])), SAFE_DIVISOR) / pairs
    return float(1 + 2 * (pairs * np.minimum(rho, 1.0) ** 2)[:max_lag].sum())
