"""Poles outside the ranges, or inside without being modes, that bend the FRFs."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.multi_mode.global_model import GlobalFit
from modallab.extraction.multi_mode.settings import PROJECTION
from modallab.extraction.multi_mode.variable_projection import affected_by_outer_modes


def out_of_band_poles(fits: Sequence[GlobalFit], freq: FloatArray) -> ComplexArray:
    """Return what was fitted below the lowest range, above the highest, and in any without being a mode.

    (n_beyond,) (rad/s)^2. Poles between two ranges stand in one for modes of the other.

    Parameters
    ----------
    fits
        At least one, in rising frequency.
    freq
        (n_freq,) Hz, of the responses.
    """
    lowest, highest = fits[0].modes.fit, fits[-1].modes.fit
    first, omega = freq[fits[0].lines][0], 2 * np.pi * freq[fits[-1].lines]
    fixed = (
        [(pole * omega[-1]) ** 2 for pole in PROJECTION.fixed_poles] if affected_by_outer_modes(omega) else []
    )
    return np.concatenate(
        [
            lowest.eigenvalue[lowest.frequency < first],
            *(fit.modes.fit.eigenvalue[fit.modes.bends] for fit in fits),
            highest.eigenvalue[2 * np.pi * highest.frequency > omega[-1]],
            np.array(fixed, complex),
        ]
    )
