"""What a laboratory sets up: points, signals, analyser, noise."""

from dataclasses import dataclass

import numpy as np

from benchmarks.laboratory.bars import Reals

WINDOW_END = 1e-3  # height at the end of the exponential window of a hammer test


@dataclass(frozen=True)
class Plan:
    """A test: a shaker and an accelerometer that roves, or fixed accelerometers and a hammer that roves."""

    driven: tuple[int, ...]
    """Node of the shaker, or nodes that the hammer strikes; along Y."""
    listening: tuple[int, ...]
    """Nodes of accelerometers, along Y."""
    hammer: bool
    hann: bool
    """Whether the source plays one random signal without end, and records are weighted by Hann."""
    frequency_max: float
    """Hz, last line."""
    n_lines: int
    """Lines from 0 Hz on."""
    averages: int
    accelerometer_mass: float
    """kg, each."""
    armature_mass: float
    """kg, of the shaker."""
    noise: float
    """rms of the white noise over the median rms of the responses; that of the force has a tenth."""
    lowest: float
    """Hz, first line that is handed over."""
    spectra: bool
    """Whether auto spectra are handed over."""

    @property
    def spacing(self) -> float:
        """Distance of two lines, Hz."""
        return self.frequency_max / (self.n_lines - 1)

    @property
    def n_samples(self) -> int:
        """Samples of a record."""
        return 1 << int(np.ceil(np.log2(2.4 * (self.n_lines - 1))))

    @property
    def freq(self) -> Reals:
        """(n_handed,), Hz, lines that are handed over."""
        lines = np.arange(self.n_lines) * self.spacing
        return np.asarray(lines[(lines > 0) & (lines >= self.lowest)])

    @property
    def runs(self) -> list["Run"]:
        """One run for each response of a shaker test, or for each blow's point of a hammer test."""
        if self.hammer:
            return [Run(node, self.listening, self.listening) for node in self.driven]
        return [Run(self.driven[0], (node,), (node,)) for node in self.listening]


@dataclass(frozen=True)
class Run:
    """One run of the analyser."""

    drive: int
    """Node."""
    listening: tuple[int, ...]
    """Nodes as the log book has them."""
    true: tuple[int, ...]
    """Nodes where the accelerometers really are."""
