"""What a multiple coherence says of each FRF of a response that several forces drive at once."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray

NONE = 1e-12  # coherence: none


def of_each_force(values: ComplexArray, multiple: FloatArray) -> FloatArray:
    """Return the coherence of each FRF, (n_freq, n_out, n_in), as if its force had acted alone.

    What is not coherent with any of the forces is noise to each. Forces that have nothing in common and are
    of like strength drive a response by `|H_k|^2` each; beside its own part a FRF has all of the noise,
    `(1 - g2)/g2 sum_l |H_l|^2`, so that

        (1 - g2_k)/g2_k = (1 - g2)/g2 . sum_l |H_l|^2 / |H_k|^2

    With one force it is the coherence itself. Forces that act one after the other have coherences of their
    own and do not come here.

    Parameters
    ----------
    values
        (n_freq, n_out, n_in) FRFs of any kind.
    multiple
        (n_freq, n_out), 0 to 1.

    References
    ----------
    Bendat, J. S. and Piersol, A. G. (2010), Random Data, 4th ed., section 9.3.
    """
    heard = multiple[:, :, None]
    if values.shape[2] == 1:
        return heard
    own = np.abs(values) ** 2
    total = own.sum(axis=2, keepdims=True)
    share = own / np.where(total > 0, total, 1.0)
    each = heard * share
    return np.minimum(each / np.maximum(each + 1 - heard, NONE), 1.0)
