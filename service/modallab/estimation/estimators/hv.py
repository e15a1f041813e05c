"""Hv: total least squares, noise on force and response alike."""

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.core.errors import InvalidInputError
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.spectra import CrossSpectra


@ESTIMATORS.register("hv")
def hv(spectra: CrossSpectra) -> ComplexArray:
    """Total least squares: between H1 and H2, for noise on force and response alike.

    Returns Hv, (n_run, n_freq, n_out, 1), response unit per N; one force at a time. The geometric
    mean of H1 and H2 with the phase of the cross spectrum is total least squares with each channel
    scaled by its own power. Rocklin, Crowley and Vold, 3rd IMAC (1985).

    Raises
    ------
    InvalidInputError
        If several forces act at once.
    """
    if spectra.ff.shape[-1] != 1:
        raise InvalidInputError("Hv is defined for one force", field="estimator", value="hv", allowed="h1")
    fx = spectra.fx[:, :, 0, :]
    size = np.sqrt(spectra.xx / spectra.ff[:, :, 0, 0, None].real)
    h: ComplexArray = size * fx / np.abs(fx)
    return h[..., None]
