"""Ordinary coherence, and the random errors that follow from it."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.numerics import COHERENCE_ROUNDING
from modallab.estimation.settings import FORCE_NOISE
from modallab.estimation.spectra import CrossSpectra


def coherence(spectra: CrossSpectra) -> FloatArray:
    """Return the coherence of each response with the forces, (n_run, n_freq, n_out), 0 to 1.

    Ordinary with one force, multiple with several: G_xf G_ff^-1 G_fx / G_xx; 1992 thesis, eq. [5.8].
    """
    ff, fx = spectra.ff, spectra.fx
    if ff.shape[2] == 1:  # one division instead of a solver call for every line
        power = (fx.real**2 + fx.imag**2)[:, :, 0] / ff[:, :, 0].real
    else:
        power = (fx.conj() * np.linalg.solve(ff, fx)).sum(axis=2).real
    safe = np.where(spectra.xx > 0, spectra.xx, 1.0)
    return np.clip(np.where(spectra.xx > 0, power / safe, 0.0), 0.0, 1.0)


def frf_error(coherence: FloatArray, averages: float) -> FloatArray:
    """Return the normalised random error of |H|, also that of the phase in radians [5.16, 5.17].

    sqrt((1 - g2) / (2 n_d g2)), g2 the coherence, shaped as it; first order in 1/n_d. The squared
    relative error of the complex H is twice the square of this.
    """
    g2 = np.maximum(coherence, np.finfo(float).tiny)
    return np.asarray(np.sqrt((1 - coherence) / (2 * averages * g2)))


def coherence_error(coherence: FloatArray, averages: float) -> FloatArray:
    """Return the normalised random error of the coherence, sqrt(2) (1 - g2)/sqrt(n_d g2) [5.18, 5.19]."""
    g2 = np.maximum(coherence, np.finfo(float).tiny)
    return np.asarray(np.sqrt(2) * (1 - coherence) / np.sqrt(averages * g2))


def incoherent_ratio(coherence: FloatArray) -> FloatArray:
    """Return the incoherent power of a response over its coherent power, (1 - g2)/g2, floored at rounding."""
    return np.asarray((1 - coherence) / np.maximum(coherence, FORCE_NOISE.min_coherence) + COHERENCE_ROUNDING)
