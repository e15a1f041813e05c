"""Residuals of modes outside the frequency bands, by weighted linear least squares."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.extraction.averaging.settings import OUT_OF_BAND


def out_of_band_columns(freq: FloatArray, poles: ComplexArray) -> ComplexArray:
    """Return the columns of the residuals in receptance, (n_freq, 2 + n_poles): `-1/omega^2`, 1, then poles.

    Parameters
    ----------
    freq
        (n_freq,) Hz; at 0 the first column is 0.
    poles
        (n_poles,) (rad/s)^2, outside the range. The term of an undamped pole is constant near it and above.
    """
    x = (2 * np.pi * freq) ** 2
    mass_line = -1 / np.where(x > 0, x, np.inf)
    reach = np.where(poles.imag == 0, OUT_OF_BAND.undamped_limit * poles.real, np.inf)
    pole_columns = 1 / (poles - np.minimum(x[:, None], reach))
    return np.concatenate([mass_line[:, None], np.ones((len(x), 1)), pole_columns], axis=1)


def fit_out_of_band(
    freq: FloatArray, remainder: ComplexArray, variance: FloatArray, poles: ComplexArray
) -> ComplexArray:
    """Return L, 1/kg, R, m/N, and a modal constant of each pole, 1/kg, (2 + n_poles, n_frf).

    Two weighted linear least-squares fits: the second adds the misfit of the first to the variance, because
    errors of the modes inside the bands do not decrease with the random error.

    Parameters
    ----------
    freq
        (n_freq,) Hz, above 0.
    remainder, variance
        (n_freq, n_frf) m/N, FRFs without modes, and E|error|^2: infinite for a line that does not count.
    poles
        (n_poles,) (rad/s)^2.
    """
    columns, usable = out_of_band_columns(freq, poles), np.isfinite(variance)
    misfit = remainder - columns @ _least_squares(columns, remainder, variance)
    # of equal power in mobility, in which FRFs are compared
    power = (usable * (freq[:, None] * np.abs(misfit)) ** 2).sum(axis=0) / np.maximum(usable.sum(axis=0), 1)
    return _least_squares(columns, remainder, variance + power / freq[:, None] ** 2)


def _least_squares(columns: ComplexArray, remainder: ComplexArray, variance: FloatArray) -> ComplexArray:
    """Return the coefficients of the columns, (n_columns, n_frf)."""
    usable = np.isfinite(variance)
    least = np.where(usable, variance, np.inf).min(axis=0, initial=np.inf)
    weight = np.where(usable, np.where(usable.any(axis=0), least, 1.0) / np.where(usable, variance, 1.0), 0.0)
    size = np.abs(columns).max(axis=0, initial=np.finfo(float).tiny)
    normalised = columns / size
    gram = np.einsum("fa,fj,fb->jab", normalised.conj(), weight, normalised, optimize=True)
    length = np.sqrt(np.maximum(np.einsum("jaa->ja", gram).real, np.finfo(float).tiny))
    products = np.einsum("fa,fj->ja", normalised.conj(), weight * remainder, optimize=True) / length
    # a pole just below the range and the mass line hardly differ in it: pseudo-inverse
    inverse = np.linalg.pinv(
        gram / (length[:, :, None] * length[:, None, :]), rcond=PRODUCT_ROUNDING, hermitian=True
    )
    return np.asarray(((inverse @ products[:, :, None])[:, :, 0] / length).T / size[:, None])
