"""Signals that begin and end within a record, on a structure at rest when the record begins."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from modallab.core.arrays import ComplexArray, FloatArray, IntArray

if TYPE_CHECKING:
    from modallab.rig.excitation import ExcitationSetting


@dataclass(frozen=True, eq=False)
class Answers:
    """What the channels of a run show after an impulse of each source at time 0.

    `samples` cover one record length before it, where a hysteretic structure's precursor and the
    anti-alias filter's are, and one after it; per sample of source that has a density of 1.
    The sources proper come first; forces that only strayed blows have come behind them.
    """

    samples: FloatArray  # (n_sources, n_ch, 2 n_samples)
    n_in: int  # sources proper

    @property
    def n_samples(self) -> int:
        """Samples of a record."""
        return int(self.samples.shape[-1] // 2)

    def after(self, moments: IntArray) -> FloatArray:
        """Return records of impulses at some samples of theirs, (n_moments, n_sources, n_ch, n_samples)."""
        windows = sliding_window_view(self.samples, self.n_samples, axis=-1)
        return np.moveaxis(windows[:, :, self.n_samples - moments], 2, 0)


class Transient(Protocol):
    """A kind of such a signal."""

    def spectrum(self, omega: FloatArray, setting: "ExcitationSetting") -> ComplexArray:
        """Return the spectrum (n_freq,) of what the source plays, over that of a white one or an impulse."""

    def strays(self, setting: "ExcitationSetting") -> bool:
        """Return whether forces beside the intended ones act."""

    def typical(self, answers: Answers, setting: "ExcitationSetting") -> Iterator[FloatArray]:
        """Yield records (n, n_ch, n_samples) whose mean spectra are the expected ones, some at a time."""

    def drawn(
        self, answers: Answers, setting: "ExcitationSetting", n: int, rng: np.random.Generator
    ) -> FloatArray:
        """Return n records, (n, n_ch, n_samples)."""

    def recurring(self, answers: Answers, setting: "ExcitationSetting") -> FloatArray | None:
        """Return the records (k, n_ch, n_samples) that all are weighted sums of; None if Gaussian."""

    def weights(
        self, answers: Answers, setting: "ExcitationSetting", n: int, rng: np.random.Generator
    ) -> FloatArray:
        """Return the weights of n records, (n, k)."""

    def moments(self, answers: Answers, setting: "ExcitationSetting") -> FloatArray:
        """Return the mean products of the weights, (k, k)."""
