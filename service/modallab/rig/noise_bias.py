"""Correction of FRFs for the bias by noise."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.frf import FrfKind, FrfSet
from modallab.estimation.force_noise import ForceChannelNoise
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.measurement import Measurement
from modallab.rig.spectrum_settings import NOISE_BIAS

_H1_EXPONENTS = {"h1": 0.0, "h2": 1.0, "hv": 0.5}  # power of the coherence that makes an estimate H1


def without_noise_bias(measurement: Measurement) -> tuple[FrfSet, FloatArray | None]:
    """Return FRFs without the bias by force and response noise, and a common variance of theirs.

    And the variance (n_freq, n_out, n_in) of ln |H| that is the force's noise, which all responses of one
    run have in common; None if it cannot be determined, and the FRFs are as
    they were: without coherence or the force's spectrum, with several forces at once, and where power
    leaks, which is not coherent either.
    """
    frf, g2, force = measurement.frf, measurement.coherence, measurement.force_spectrum
    ambiguous = g2 is None or (g2.ndim == 2 and len(frf.inputs) > 1)
    leaks = EXCITATIONS[measurement.setup.analyser.excitation.kind].continuous > 0
    if g2 is None or force is None or ambiguous or leaks or measurement.averages <= NOISE_BIAS.min_averages:
        return frf, None
    g2 = g2.reshape(frf.values.shape)
    h1_factor = g2 ** _H1_EXPONENTS[measurement.setup.analyser.estimator]
    force = np.where(force > 0, force, 1.0)
    response_power = np.abs(frf.to(FrfKind.INERTANCE).values * h1_factor) ** 2 * force
    columns = (len(frf.freq), -1)
    noise = ForceChannelNoise.of(
        frf.freq > 0, *(array.reshape(columns) for array in (g2, force, response_power))
    )
    if noise is None:
        return frf, None
    noise_ratio = noise.rise.reshape(g2.shape)
    uncorrelated = measurement.setup.accelerometers.roving or len(frf.outputs) < 2
    values, variance = (
        frf.values * h1_factor * (1 + noise_ratio),
        noise_ratio / (2 * (measurement.averages - NOISE_BIAS.min_averages)),
    )
    return FrfSet(frf.freq, values, frf.outputs, frf.inputs, frf.kind), None if uncorrelated else variance
