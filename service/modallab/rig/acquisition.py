"""Signal levels and sampling that the analyser uses."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.fft

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.rig.analyser import Analyser
from modallab.rig.channel import Channel
from modallab.rig.settings import ACQUISITION


def samples_of(analyser: Analyser) -> int:
    """Return the number of samples of a record."""
    return int(
        scipy.fft.next_fast_len(int(np.ceil(ACQUISITION.rate_ratio * (analyser.n_lines - 1))), real=True)
    )


def sample_rate_of(analyser: Analyser) -> float:
    """Return the sample rate, Hz."""
    return samples_of(analyser) * analyser.spacing


@dataclass(frozen=True, eq=False)
class Acquisition:
    """Analyser settings and signal levels of every run; force channels come first."""

    analyser: Analyser
    n_in: int
    rms: FloatArray  # (n_run, n_ch) of the signals over the band, noise of the sensors left out
    noise: FloatArray  # (n_run, n_ch) one-sided densities of the sensors' white noise, unit^2/Hz
    channels: tuple[tuple[Channel, ...], ...]  # (n_run, n_ch)

    @property
    def sample_rate(self) -> float:
        """Hz."""
        return sample_rate_of(self.analyser)

    def channel_mask(self, concerned: Callable[[Channel], bool]) -> BoolArray:
        """Return the mask (n_run, n_ch) of the channels that satisfy a condition."""
        return np.array([[concerned(channel) for channel in run] for run in self.channels])


@dataclass(frozen=True, eq=False)
class Batch:
    """Some records of one run."""

    run: int
    starts: IntArray  # (n_block,) first sample of each record, counted from the first of the run
    samples: FloatArray  # (n_block, n_ch, n_samples)
