"""From time records to averaged spectra, block by block, and what the averages are worth."""

import numpy as np
import scipy.fft

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.windows import Window

IN_CACHE = 2**15  # samples transformed at once: larger batches run at the speed of memory
FINE = 4096  # samples of a window for its overlap with itself: exact for sums of cosines at this length


def effective_averages(averages: int, overlap: float, window: Window) -> float:
    """Return how many independent records are worth `averages` overlapping ones.

    Welch (1967), IEEE Trans. Audio Electroacoustics 15, 70-73: n / (1 + 2 sum_k (1 - k/n) rho_k), rho_k the
    squared correlation of the window with itself k steps on. Signals that are flat over a line.

    Parameters
    ----------
    averages
        Records taken, overlapping ones counted each.
    overlap
        Share of a record that the next one has in common with it, 0 to below 1.
    """
    w = window.samples(FINE)
    total = 1.0
    for k in range(1, averages):
        shift = round(k * (1 - overlap) * FINE)
        if shift >= FINE:
            break
        correlation = (w[shift:] @ w[: FINE - shift]) / (w @ w)
        total += 2 * (1 - k / averages) * correlation**2
    return averages / total


class Averager:
    """Sums of the auto and cross spectra of one run's channels; memory does not grow with the averages."""

    def __init__(self, window: Window, n_samples: int, sample_rate: float, n_lines: int, n_in: int) -> None:
        self._w = window.samples(n_samples)
        self._n_lines, self._n_in, self.count = n_lines, n_in, 0
        self._scale = 2 / (sample_rate * n_samples * window.power)
        self._ff: ComplexArray | float = 0.0
        self._fx: ComplexArray | float = 0.0
        self._xx: FloatArray | float = 0.0

    def add(self, blocks: FloatArray) -> None:
        """Take in records (n_block, n_ch, n_samples), forces first among the channels."""
        n_block, n_ch, n = blocks.shape
        batch = max(1, IN_CACHE // (n_ch * n))
        for start in range(0, n_block, batch):
            windowed = blocks[start : start + batch] * self._w
            lines = scipy.fft.rfft(windowed, overwrite_x=True)[..., : self._n_lines]
            f, x = lines[:, : self._n_in], lines[:, self._n_in :]
            back = f.conj()
            self._ff += (back[:, :, None] * f[:, None]).sum(axis=0)
            self._fx += (back[:, :, None] * x[:, None]).sum(axis=0)
            self._xx += (x.real**2 + x.imag**2).sum(axis=0)
        self.count += n_block

    def densities(self) -> tuple[ComplexArray, ComplexArray, FloatArray]:
        """Return one-sided G_ff (n_lines, n_in, n_in), G_fx (n_lines, n_in, n_out), G_xx (n_lines, n_out)."""
        scale = self._scale / self.count
        ff, fx, xx = (np.moveaxis(scale * np.asarray(g), -1, 0) for g in (self._ff, self._fx, self._xx))
        return ff, fx, xx
