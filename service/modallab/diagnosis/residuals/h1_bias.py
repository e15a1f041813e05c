"""Share of the noise of a force that biases H1, fitted where no log book declares the noise.

Noise of the force lowers the coherence and biases H1 low. Noise in proportion to the responses lowers the
coherence alike, without a bias of H1. The coherence cannot distinguish them; FRFs of the right model can.
"""

from typing import TYPE_CHECKING

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.diagnosis.residuals.normalised_difference import logarithm_weight
from modallab.diagnosis.residuals.predicted import frfs_side_by_side
from modallab.diagnosis.residuals.settings import H1_BIAS
from modallab.estimation.estimators.h1 import h1
from modallab.estimation.spectra import CrossSpectra

if TYPE_CHECKING:
    from modallab.diagnosis.residuals.observed import Observed


def share_of_bias(spectra: CrossSpectra, noise_ratio: FloatArray, observed: "Observed") -> float:
    """Return the share of noise of the force, 0 to 1, whose bias of H1 fits the measured FRFs best.

    By weighted least squares: a share s of the noise lowers ln |H1| by ln(1 + s N/G_ff). Gauss-Newton steps.

    Parameters
    ----------
    spectra
        Expected spectra at the measured lines, of forces without that noise.
    noise_ratio
        (n_run, n_freq, n_in), noise over the spectrum of each force.
    """
    h = h1(spectra)
    measured, expected = np.abs(observed.h), np.abs(frfs_side_by_side(h))
    used = observed.fitted & (measured > 0) & (expected > 0)
    ratio = np.where(used, frfs_side_by_side(np.broadcast_to(noise_ratio[:, :, None], h.shape)), 0.0)
    difference = np.log(np.where(used, measured, 1.0) / np.where(used, expected, 1.0)) - observed.bias
    # Where random errors are large a logarithm is biased itself.
    weight = used * logarithm_weight(observed.error) / observed.error**2
    share = 0.0
    for _ in range(H1_BIAS.max_iterations):
        lowered = 1 + share * ratio
        slope = ratio / lowered
        gradient = float((weight * slope * (difference + np.log(lowered))).sum())
        curvature = float((weight * slope**2).sum()) + SAFE_DIVISOR
        before, share = share, float(np.clip(share - gradient / curvature, 0.0, 1.0))
        if abs(share - before) < H1_BIAS.tolerance:
            break
    return share
