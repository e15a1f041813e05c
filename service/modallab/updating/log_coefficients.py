"""Coefficients by their logarithms: a third and three times as much are equally far from nominal."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.updating.parameterisation import Parameterisation


def log_changes(parameterisation: Parameterisation, values: FloatArray) -> FloatArray:
    """Return distances of coefficients (n_params,) from nominal: logarithms, or added loss factors.

    A factor of mass or stiffness is positive, so that its logarithm exists.
    """
    return np.asarray(np.where(parameterisation.damping, values, np.log(np.where(values > 0, values, 1.0))))


def from_log_changes(parameterisation: Parameterisation, log_changes: FloatArray) -> FloatArray:
    """Return coefficients (n_params,) for given distances from nominal, clipped to their bounds."""
    damping = parameterisation.damping
    values = np.where(damping, log_changes, np.exp(np.where(damping, 0.0, log_changes)))
    return np.asarray(np.clip(values, *parameterisation.bounds))


def log_derivatives(parameterisation: Parameterisation, values: FloatArray) -> FloatArray:
    """Return derivatives of coefficients with respect to their log changes, (n_params,)."""
    return np.asarray(np.where(parameterisation.damping, 1.0, values))
