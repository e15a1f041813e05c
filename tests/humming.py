"""Measurements of a laboratory that hums in the force as well."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.rig.measurement import Measurement

HANN = {-1: 1 / 6, 0: 2 / 3, 1: 1 / 6}
"""Shares of a sine's power in the lines about its own."""


def with_hum(test: Measurement, line: int, in_force: float, in_response: float) -> Measurement:
    """Return an uploaded measurement with a sine on a line in both channels, of constant phase between them.

    Parameters
    ----------
    test
        Measurement through a Hann window.
    line
        Number of the line, from 0 Hz on.
    in_force, in_response
        Rms of the sine over that of the mean line of each channel. Its phase is another one in every run.
    """
    assert test.force_spectrum is not None
    assert test.response_spectrum is not None
    assert test.coherence is not None
    ff, xx, h = test.force_spectrum.copy(), test.response_spectrum.copy(), test.frf.values
    fx: ComplexArray = h * ff
    power_force = in_force**2 * ff.mean(axis=0)
    power_response = in_response**2 * xx.mean(axis=0)
    phase = np.exp(2j * np.pi * np.random.default_rng(line).uniform(size=power_force.shape))
    for offset, share in HANN.items():
        i = line + offset
        ff[i] += share * power_force
        xx[i] += share * power_response
        fx[i] += share * phase * np.sqrt(power_force * power_response[:, None])
    g2 = np.abs(fx[..., 0]) ** 2 / (ff[..., 0] * xx)
    frf = replace(test.frf, values=fx / ff)
    return replace(
        test, frf=frf, force_spectrum=ff, response_spectrum=xx, coherence=np.minimum(g2, 1), route=None
    )
