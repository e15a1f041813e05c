"""Ratios of noise to signal of force and responses."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.numerics import SAFE_DIVISOR


@dataclass(frozen=True, eq=False)
class NoiseToSignal:
    """Ratio of noise power to signal power at each line."""

    force: FloatArray
    """(n_freq,) of the force."""
    response: FloatArray
    """(n_freq, n_frf) of the responses."""

    @property
    def force_share(self) -> FloatArray:
        """(n_freq, n_frf) part of the random error of each line, as variance, by noise of the force."""
        total = np.maximum(self.force[:, None] + self.response, SAFE_DIVISOR)
        return np.asarray(self.force[:, None] / total)

    def at(self, lines: slice) -> "NoiseToSignal":
        """Return the ratios at some lines."""
        return NoiseToSignal(self.force[lines], self.response[lines])

    def of_frfs(self, frfs: IntArray) -> "NoiseToSignal":
        """Return the ratios of some FRFs."""
        return NoiseToSignal(self.force, self.response[:, frfs])
