"""Averaged spectra of time records, block by block, and the effective number of averages."""

from collections.abc import Collection
from functools import lru_cache

import numpy as np
import scipy.fft

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.settings import SPECTRUM
from modallab.estimation.windows import Window

Densities = tuple[ComplexArray, ComplexArray, FloatArray]


@lru_cache(maxsize=64)
def effective_averages(averages: int, overlap: float, window: Window) -> float:
    """Return the effective number of independent averages of `averages` overlapping records.

    Welch (1967), IEEE Trans. Audio Electroacoustics 15, 70-73: n / (1 + 2 sum_k (1 - k/n) rho_k), rho_k the
    squared correlation of the window with itself k steps on. Signals that are flat over a line.

    Parameters
    ----------
    averages
        Number of records, overlapping ones included.
    overlap
        Fraction of a record that overlaps with the next one, 0 to below 1.
    """
    w = window.samples(SPECTRUM.window_samples)
    total = 1.0
    for k in range(1, averages):
        shift = round(k * (1 - overlap) * SPECTRUM.window_samples)
        if shift >= SPECTRUM.window_samples:
            break
        correlation = float((w[shift:] @ w[: SPECTRUM.window_samples - shift]) / (w @ w))
        total += 2 * (1 - k / averages) * correlation**2
    return averages / total


def counts_of(n: int, averages: int, first: int = 1) -> tuple[int, ...]:
    """Return numbers of averages from the first to all, ascending, as evenly spaced in ratio as counts are.

    Random errors fall with the square root of the averages: equal ratios are equal steps of them.

    Parameters
    ----------
    n
        How many; fewer where there are not as many averages.
    """
    counts = [min(first, averages)]
    for left in range(n - 1, 0, -1):
        last = counts[-1]
        if last == averages:
            break
        counts.append(max(last + 1, round(last * (averages / last) ** (1 / left))))
    return tuple(counts)


class Averager:
    """Sums of the auto and cross spectra of one run's channels; memory does not grow with the averages.

    Parameters
    ----------
    noted
        Numbers of averages after which the spectra as they are then are kept, in `snapshots`.
    """

    def __init__(
        self,
        window: Window,
        shape: tuple[int, int],
        sample_rate: float,
        *,
        n_lines: int,
        n_in: int,
        noted: Collection[int] = (),
    ) -> None:
        n_ch, n_samples = shape
        n_out = n_ch - n_in
        self.count = 0
        self.snapshots: list[Densities] = []
        self._noted = frozenset(noted)
        self._w = window.weights(n_samples, n_in, n_out)
        self._batch = max(1, SPECTRUM.batch_samples // (n_ch * n_samples))
        self._windowed = np.empty((self._batch, *shape))
        self._scale = 2 / (sample_rate * n_samples * window.power)
        self._ff: ComplexArray = np.zeros((n_in, n_in, n_lines), complex)
        self._fx: ComplexArray = np.zeros((n_in, n_out, n_lines), complex)
        self._xx = np.zeros((n_out, 2 * n_lines))  # squares of real and imaginary parts, in turns

    def add(self, blocks: FloatArray) -> None:
        """Take in records (n_block, n_ch, n_samples), forces first among the channels."""
        n_in, _, n_lines = self._fx.shape
        for start in range(0, len(blocks), self._batch):
            part = blocks[start : start + self._batch]
            windowed = np.multiply(part, self._w, out=self._windowed[: len(part)])
            for lines in scipy.fft.rfft(windowed, overwrite_x=True):
                f, x = lines[:n_in, :n_lines], lines[n_in:, :n_lines]
                conjugate = f.conj()[:, None]
                self._ff += conjugate * f
                self._fx += conjugate * x
                parts = x.view(float)
                self._xx += parts * parts
                self.count += 1
                if self.count in self._noted:
                    self.snapshots.append(self.densities())

    def densities(self) -> Densities:
        """Return one-sided G_ff (n_lines, n_in, n_in), G_fx (n_lines, n_in, n_out), G_xx (n_lines, n_out)."""
        scale = self._scale / self.count
        ff: ComplexArray = np.moveaxis(self._ff, -1, 0) * scale
        fx: ComplexArray = np.moveaxis(self._fx, -1, 0) * scale
        xx = scale * self._xx.reshape(*self._fx.shape[1:], 2).sum(axis=2).T
        return ff, fx, xx
