"""FRFs freed of what noise makes of them on the whole."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.frf import FrfKind, FrfSet
from modallab.estimation.force_noise import ForceChannelNoise
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.measurement import Measurement

UNKNOWN = 2  # averages up to which coherence says nothing
OF_H1 = {"h1": 0.0, "h2": 1.0, "hv": 0.5}  # power of the coherence that makes an estimate H1


def without_noise_bias(measurement: Measurement) -> tuple[FrfSet, FloatArray | None]:
    """Return FRFs that noise of force and responses makes neither too small nor too large.

    And the variance (n_freq, n_out, n_in) of ln |H| that is the force's noise, which all responses of one
    run have in common; None where nothing tells how strong it is, and the FRFs are as
    they were: without coherence or the force's spectrum, with several forces at once, and where power
    leaks, which is not coherent either.
    """
    frf, g2, force = measurement.frf, measurement.coherence, measurement.force_spectrum
    several = g2 is None or (g2.ndim == 2 and len(frf.inputs) > 1)
    leaks = EXCITATIONS[measurement.setup.analyser.excitation.kind].continuous > 0
    if g2 is None or force is None or several or leaks or measurement.averages <= UNKNOWN:
        return frf, None
    g2 = g2.reshape(frf.values.shape)
    to_h1 = g2 ** OF_H1[measurement.setup.analyser.estimator]
    force = np.where(force > 0, force, 1.0)
    heard = np.abs(frf.to(FrfKind.INERTANCE).values * to_h1) ** 2 * force
    columns = (len(frf.freq), -1)
    noise = ForceChannelNoise.of(frf.freq > 0, *(one.reshape(columns) for one in (g2, force, heard)))
    if noise is None:
        return frf, None
    rise = noise.rise.reshape(g2.shape)
    alone = measurement.setup.accelerometers.roving or len(frf.outputs) < 2
    values, variance = frf.values * to_h1 * (1 + rise), rise / (2 * (measurement.averages - UNKNOWN))
    return FrfSet(frf.freq, values, frf.outputs, frf.inputs, frf.kind), None if alone else variance
