"""H1: least squares on the response."""

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.spectra import CrossSpectra


@ESTIMATORS.register("h1")
def h1(spectra: CrossSpectra) -> ComplexArray:
    """Least squares on the response: low where the force is noisy, worst at resonances.

    Returns H1, (n_run, n_freq, n_out, n_in), response unit per N. At resonances the force dips.
    With exp(+i omega t) and G_fx = E[conj(F) X], H1 solves G_ff H^T = G_fx; 1992 thesis, eq. [5.6].
    """
    if spectra.ff.shape[2] == 1:  # one division instead of a solver call for every line
        return np.asarray((spectra.fx / spectra.ff).swapaxes(-1, -2))
    return np.asarray(np.linalg.solve(spectra.ff, spectra.fx).swapaxes(-1, -2))
