"""Coefficients by their logarithms: a third and three times as much are as far from no change."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.updating.parameterisation import Parameterisation


def log_changes(parameterisation: Parameterisation, values: FloatArray) -> FloatArray:
    """Return how far coefficients (n_params,) are from no change: logarithms, of loss factors what is added.

    What multiplies a mass or a stiffness is above zero whatever its logarithm is.
    """
    return np.asarray(np.where(parameterisation.damping, values, np.log(np.where(values > 0, values, 1.0))))


def from_log_changes(parameterisation: Parameterisation, log_changes: FloatArray) -> FloatArray:
    """Return coefficients (n_params,) that are so far from no change, within their bounds."""
    damping = parameterisation.damping
    values = np.where(damping, log_changes, np.exp(np.where(damping, 0.0, log_changes)))
    return np.asarray(np.clip(values, *parameterisation.bounds))


def log_derivatives(parameterisation: Parameterisation, values: FloatArray) -> FloatArray:
    """Return (n_params,) how fast coefficients move with their changes."""
    return np.asarray(np.where(parameterisation.damping, 1.0, values))
