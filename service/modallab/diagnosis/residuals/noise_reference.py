"""Noise of the force, a ratio to its mean spectrum: to the one measured, or to the one expected.

A missing effect, as a resonance of the stinger, changes the mean force by up to an order of magnitude. Who
states noise as a ratio may have had either force in mind, so the noise is fitted between the two levels.
"""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.numerics import COHERENCE_ROUNDING, SAFE_DIVISOR
from modallab.diagnosis.residuals.settings import NOISE_REFERENCE
from modallab.estimation.spectra import CrossSpectra


@dataclass(frozen=True, eq=False)
class ExpectedForceNoise:
    """Noise of the force channels at the declared ratio to the force expected without a missing effect."""

    force: FloatArray
    """(n_run, n_freq) N^2/Hz, this force at the measured lines, with noise."""
    noise: FloatArray
    """(n_run,) N^2/Hz, the noise."""

    def at(self, lines: IntArray) -> "ExpectedForceNoise":
        """Return the same at some of the lines, (n,) indices."""
        return replace(self, force=self.force[:, lines])

    def excess(self, spectra: CrossSpectra) -> FloatArray | None:
        """Return this noise less that at the same ratio to the force of other spectra, (n_run,) N^2/Hz.

        None if both are the same.

        Parameters
        ----------
        spectra
            Expected spectra of one force a run, at the same lines.
        """
        ratio = spectra.ff[:, :, 0, 0].real.mean(axis=1) / (self.force.mean(axis=1) + SAFE_DIVISOR)
        if np.abs(ratio - 1).max() < NOISE_REFERENCE.least_change:
            return None
        return np.asarray(self.noise * (1 - ratio))


@dataclass(frozen=True, eq=False)
class IncoherentSpectra:
    """Incoherent response spectra, measured and expected, (n_freq, n_out) each."""

    measured: FloatArray
    """(m/s^2)^2/Hz."""
    weight: FloatArray
    """Inverse variance of its logarithm; 0 where it is not used."""
    expected: FloatArray
    """(m/s^2)^2/Hz."""
    coherent: FloatArray
    """(m/s^2)^2/Hz, expected response to the force."""

    def fitted_share(self, excess: FloatArray) -> float:
        """Return the share, 0 to 1, of more noise of the force that fits the measured spectra best.

        With a share t of the excess E the force G_ff + t E makes the incoherent spectrum
        I + C (1 - 1/(1 + t E/G_ff)), C the response to the force. Gauss-Newton steps of its logarithm.

        Parameters
        ----------
        excess
            (n_freq, n_out), more noise of the force over the expected force.
        """
        share, logarithm = 0.0, np.log(self.measured)
        least = COHERENCE_ROUNDING * (self.expected + self.coherent)
        for _ in range(NOISE_REFERENCE.max_iterations):
            force = np.maximum(1 + share * excess, COHERENCE_ROUNDING)
            expected = np.maximum(self.expected + self.coherent * (1 - 1 / force), least)
            slope = self.coherent * excess / (force**2 * expected)
            gradient = float((self.weight * slope * (logarithm - np.log(expected))).sum())
            curvature = float((self.weight * slope**2).sum()) + SAFE_DIVISOR
            before, share = share, float(np.clip(share + gradient / curvature, 0.0, 1.0))
            if abs(share - before) < NOISE_REFERENCE.tolerance:
                break
        return share
