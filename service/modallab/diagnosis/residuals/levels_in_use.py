"""Log books and measurements with the levels that spectra show, where a log book leaves them open."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from modallab.core.arrays import IntArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.diagnosis.residuals.free_levels import ALL_DECLARED
from modallab.diagnosis.residuals.noise_reference import ExpectedForceNoise
from modallab.diagnosis.residuals.observed import Observed
from modallab.rig.chain import Chain
from modallab.rig.expected import expected_spectra, noise_free, noise_in_lines, with_noise
from modallab.rig.hardware import Noise, NoiseDensity
from modallab.rig.setup import RigSetup


def with_measured_level(setup: RigSetup, observed: Observed) -> RigSetup:
    """Return a log book with the level that the measured force spectrum shows, where none is declared.

    Its median over lines and runs: drop-outs at resonances take part in few lines.
    """
    analyser = setup.analyser
    if analyser.excitation.level is not None or observed.force is None:
        return setup
    lines = observed.usable.any(axis=1)
    unit = analyser.source_density(observed.freq[lines])
    ratio = observed.force[lines] / (unit[:, None] + SAFE_DIVISOR)
    excitation = replace(analyser.excitation, level=float(analyser.source_level * np.sqrt(np.median(ratio))))
    return replace(setup, analyser=replace(analyser, excitation=excitation))


def with_expected_force_noise(
    observed: Observed, measuring_chain: Callable[[], Chain], lines: IntArray
) -> Observed:
    """Return a measurement with the noise of the force at its ratio to the expected one, where it is needed.

    Parameters
    ----------
    measuring_chain
        Returns that of the log book, without a missing effect.
    lines
        (n,) indices of the measured lines.
    """
    if not observed.free_levels.noise_reference:
        return observed
    clean = noise_free(chain := measuring_chain())
    force = with_noise(chain, clean).ff[:, lines, 0, 0].real
    noise = ExpectedForceNoise(force, noise_in_lines(chain, clean)[:, 0])
    return replace(observed, free_levels=replace(observed.free_levels, expected_force_noise=noise))


def with_levels_declared(
    setup: RigSetup, observed: Observed, measuring_chain: Callable[[], Chain], lines: IntArray
) -> tuple[RigSetup, Observed]:
    """Return log book and measurement of a test to be made, with the fitted noise in place of what is open.

    Parameters
    ----------
    measuring_chain
        Returns that of the measured test.
    lines
        (n,) indices of its measured lines.
    """
    levels = observed.free_levels
    expected = expected_spectra(measuring_chain()) if levels.noise else None
    if expected is not None and (noise := levels.fitted_noise(expected, observed, lines)) is not None:
        force, response = setup.noise.force, setup.noise.response
        # A further test may have other responses: they have the mean of those measured, over all lines.
        parts = noise.force_at(observed.freq), noise.response_at(observed.freq)
        fitted = tuple(NoiseDensity(float(np.mean(part))) for part in parts)
        setup = replace(
            setup,
            noise=Noise(fitted[0] if force is None else force, fitted[1] if response is None else response),
        )
    return setup, replace(observed, free_levels=ALL_DECLARED)
