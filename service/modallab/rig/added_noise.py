"""Noise of the channels that a log book leaves open, added to spectra without it."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.spectra import CrossSpectra


@dataclass(frozen=True, eq=False)
class AddedNoise:
    """What noise adds to the auto spectra of every run."""

    ff: ComplexArray
    """(n_run, n_freq, n_in, n_in) N^2/Hz."""
    xx: FloatArray
    """(n_run, n_freq, n_out) (m/s^2)^2/Hz."""

    @classmethod
    def between(cls, expected: CrossSpectra, noisy: CrossSpectra) -> "AddedNoise":
        """Return the noise by which expected spectra differ from noisy ones of the same signals."""
        return cls(noisy.ff - expected.ff, noisy.xx - expected.xx)

    def in_single_run(self) -> "AddedNoise":
        """Return the noise of one run with the responses of all runs, and the mean noise of the force."""
        by_line = self.xx.swapaxes(0, 1)
        return AddedNoise(self.ff.mean(axis=0, keepdims=True), by_line.reshape(1, len(by_line), -1))

    def added_to(self, spectra: CrossSpectra) -> CrossSpectra:
        """Return spectra with the noise."""
        return replace(spectra, ff=spectra.ff + self.ff, xx=np.maximum(spectra.xx + self.xx, 0.0))
