"""Errors of declared noise levels, each the same at all lines of a channel."""

from dataclasses import replace

import numpy as np

from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import Residual


def without_noise_level_errors(observed: Observed, found: Residual, largest: float) -> Residual:
    """Return residuals without the error of each channel's noise level, as large as it may be.

    A log book tells noise to some per cent. However many lines a channel has, they share this error.

    Parameters
    ----------
    largest
        Largest error of the natural logarithm of a channel's noise power.
    """
    if found.response is None or observed.incoherent_variance is None:
        return found
    entries = found.mask_of("response", observed.usable)
    slope = np.where(entries, 1 / np.sqrt(observed.incoherent_variance), 0.0)
    curvature = np.maximum((slope**2).sum(axis=0), np.finfo(float).tiny)
    level = np.clip((slope * found.response).sum(axis=0) / curvature, -largest, largest)
    return replace(found, response=found.response - slope * level)
