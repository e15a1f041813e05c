"""Errors of declared noise levels, each the same at all lines of a channel."""

from dataclasses import replace

import numpy as np

from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import Residual


def without_noise_level_errors(observed: Observed, residual: Residual, largest: float) -> Residual:
    """Return residuals without the error of each channel's noise level, up to a largest one.

    A log book tells noise to some per cent. However many lines a channel has, they share this error.

    Parameters
    ----------
    largest
        Largest error of the natural logarithm of a channel's noise power.
    """
    if residual.response is None or observed.incoherent_variance is None:
        return residual
    entries = residual.mask_of("response", observed.usable)
    slope = np.where(entries, 1 / np.sqrt(observed.incoherent_variance), 0.0)
    curvature = np.maximum((slope**2).sum(axis=0), np.finfo(float).tiny)
    level = np.clip((slope * residual.response).sum(axis=0) / curvature, -largest, largest)
    return replace(residual, response=residual.response - slope * level)
