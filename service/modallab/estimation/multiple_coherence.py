"""Coherence of each FRF of a response to several simultaneous forces, from the multiple coherence."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING


def coherence_per_force(values: ComplexArray, multiple: FloatArray) -> FloatArray:
    """Return the coherence of each FRF as if its force had acted alone, (n_freq, n_out, n_in).

    The incoherent part of a response is noise for each of its FRFs. Uncorrelated forces of equal power
    contribute `|H_k|^2` each to the power of the response, and each FRF has all of the noise
    `(1 - g2)/g2 sum_l |H_l|^2`, so that

        (1 - g2_k)/g2_k = (1 - g2)/g2 . sum_l |H_l|^2 / |H_k|^2

    With one force this is the coherence itself. It does not apply to forces that act one after the other.

    Parameters
    ----------
    values
        (n_freq, n_out, n_in) FRFs of any kind.
    multiple
        (n_freq, n_out) multiple coherence, 0 to 1.

    References
    ----------
    Bendat, J. S. and Piersol, A. G. (2010), Random Data, 4th ed., section 9.3.
    """
    total_coherence = multiple[:, :, None]
    if values.shape[2] == 1:
        return total_coherence
    power = np.abs(values) ** 2
    total = power.sum(axis=2, keepdims=True)
    fraction = power / np.where(total > 0, total, 1.0)
    coherent_part = total_coherence * fraction
    return np.minimum(coherent_part / np.maximum(coherent_part + 1 - total_coherence, PRODUCT_ROUNDING), 1.0)
