"""Impulse responses of the channels of a run."""

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from modallab.core.arrays import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class ImpulseResponses:
    """Responses of the channels of a run to an impulse of each source at time 0.

    `samples` cover one record length before the impulse, for the precursors of hysteretic damping and of the
    anti-alias filter, and one after it; scaled for a source of unit density.
    The declared sources come first, then the additional forces of misaligned blows.
    """

    samples: FloatArray
    """(n_sources, n_ch, 2 n_samples) impulse responses of all channels."""
    n_in: int
    """Number of declared sources, which come first."""

    @property
    def n_samples(self) -> int:
        """Samples of a record."""
        return int(self.samples.shape[-1] // 2)

    def records_after(self, moments: IntArray) -> FloatArray:
        """Return records of impulses at some samples of theirs, (n_moments, n_sources, n_ch, n_samples)."""
        windows = sliding_window_view(self.samples, self.n_samples, axis=-1)
        return np.moveaxis(windows[:, :, self.n_samples - moments], 2, 0)

    def period_after(self, sample: int) -> FloatArray:
        """Return the record of an impulse at a sample of it, (n_sources, n_ch, n_samples).

        What comes before the record, of models that are not causal, is put at its end: a period of it has
        the lines of the endless response.
        """
        before = self.n_samples - sample
        record = self.samples[..., before : before + self.n_samples].copy()
        record[..., sample:] += self.samples[..., :before]
        return record
