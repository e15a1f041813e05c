"""Residual poles: poles outside the ranges, and poles inside that are not modes."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.multi_mode.fit_settings import PROJECTION
from modallab.extraction.multi_mode.global_model import GlobalFit
from modallab.extraction.multi_mode.variable_projection import affected_by_outer_modes


def out_of_band_poles(fits: Sequence[GlobalFit], freq: FloatArray) -> ComplexArray:
    """Return the residual poles, (n_poles,) (rad/s)^2.

    These are poles below the lowest range, above the highest, and poles inside a range that are not modes.
    Poles between two ranges are excluded, because they represent modes of the other range.

    Parameters
    ----------
    fits
        At least one fit, in ascending frequency.
    freq
        (n_freq,) Hz, lines of the responses.
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
