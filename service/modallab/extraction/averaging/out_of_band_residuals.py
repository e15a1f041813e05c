"""What lies outside the bands, fitted to what modes leave in them."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray

HELD = 0.5  # of an undamped pole, in omega^2: it bends lines below, and is no resonance of any
ALIKE = 1e-12  # of a combination of columns of unit length, squared: less is rounding


def out_of_band_columns(freq: FloatArray, beyond: ComplexArray) -> ComplexArray:
    """Return what residuals multiply in receptance, (n_freq, 2 + n_beyond): `-1/omega^2`, 1, then poles.

    Parameters
    ----------
    freq
        (n_freq,) Hz; at 0 the first column is 0.
    beyond
        (n_beyond,) (rad/s)^2. An undamped one is held above the range: from near it on it is a constant.
    """
    x = (2 * np.pi * freq) ** 2
    below = -1 / np.where(x > 0, x, np.inf)
    reach = np.where(beyond.imag == 0, HELD * beyond.real, np.inf)
    poles = 1 / (beyond - np.minimum(x[:, None], reach))
    return np.concatenate([below[:, None], np.ones((len(x), 1)), poles], axis=1)


def fit_out_of_band(
    freq: FloatArray, rest: ComplexArray, variance: FloatArray, beyond: ComplexArray
) -> ComplexArray:
    """Return L, 1/kg, R, m/N, and a modal constant for each pole beyond, 1/kg, (2 + n_beyond, n_frf).

    Weighted linear least squares, twice: what modes lack inside the bands is not known before, and no
    smaller where random error is.

    Parameters
    ----------
    freq
        (n_freq,) Hz, above 0.
    rest, variance
        (n_freq, n_frf) m/N, and its square: infinite for a line that does not count.
    beyond
        (n_beyond,) (rad/s)^2.
    """
    columns, known = out_of_band_columns(freq, beyond), np.isfinite(variance)
    left = rest - columns @ _fitted(columns, rest, variance)
    # alike in mobility, in which FRFs are held against each other
    power = (known * (freq[:, None] * np.abs(left)) ** 2).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    return _fitted(columns, rest, variance + power / freq[:, None] ** 2)


def _fitted(columns: ComplexArray, rest: ComplexArray, variance: FloatArray) -> ComplexArray:
    """Return the coefficients of the columns, (n_columns, n_frf)."""
    known = np.isfinite(variance)
    least = np.where(known, variance, np.inf).min(axis=0, initial=np.inf)
    weight = np.where(known, np.where(known.any(axis=0), least, 1.0) / np.where(known, variance, 1.0), 0.0)
    size = np.abs(columns).max(axis=0, initial=np.finfo(float).tiny)
    even = columns / size
    gram = np.einsum("fa,fj,fb->jab", even.conj(), weight, even, optimize=True)
    length = np.sqrt(np.maximum(np.einsum("jaa->ja", gram).real, np.finfo(float).tiny))
    right = np.einsum("fa,fj->ja", even.conj(), weight * rest, optimize=True) / length
    # a pole just below the range and what is further below hardly differ in it
    inverse = np.linalg.pinv(gram / (length[:, :, None] * length[:, None, :]), rcond=ALIKE, hermitian=True)
    return np.asarray(((inverse @ right[:, :, None])[:, :, 0] / length).T / size[:, None])
