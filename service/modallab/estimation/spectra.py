"""Averaged spectra of the runs of a test."""

from collections.abc import Sequence
from dataclasses import dataclass

from modallab.core.arrays import ComplexArray, FloatArray, IntArray, frozen


@dataclass(frozen=True, eq=False)
class CrossSpectra:
    """One-sided auto and cross spectra, run by run; G_fx = E[conj(F) X].

    At 0 Hz, too, the density is twice the two-sided one, so that white noise is flat over all lines.
    """

    freq: FloatArray  # (n_freq,) Hz
    ff: ComplexArray  # (n_run, n_freq, n_in, n_in) N^2/Hz
    fx: ComplexArray  # (n_run, n_freq, n_in, n_out) N m/s^2/Hz
    xx: FloatArray  # (n_run, n_freq, n_out) (m/s^2)^2/Hz
    averages: float  # effective, independent

    def __post_init__(self) -> None:
        n_run, n_freq, n_in, n_out = self.fx.shape
        object.__setattr__(self, "freq", frozen(self.freq, float, (n_freq,), name="freq"))
        object.__setattr__(self, "ff", frozen(self.ff, complex, (n_run, n_freq, n_in, n_in), name="ff"))
        object.__setattr__(self, "fx", frozen(self.fx, complex, self.fx.shape, name="fx"))
        object.__setattr__(self, "xx", frozen(self.xx, float, (n_run, n_freq, n_out), name="xx"))

    def with_runs(self, runs: Sequence[int], other: "CrossSpectra") -> "CrossSpectra":
        """Return the spectra with some runs, by their indices, exchanged for those of other spectra."""
        parts = self.ff.copy(), self.fx.copy(), self.xx.copy()
        for part, replacement in zip(parts, (other.ff, other.fx, other.xx), strict=True):
            part[list(runs)] = replacement
        return CrossSpectra(self.freq, *parts, self.averages)

    def of_runs(self, runs: Sequence[int]) -> "CrossSpectra":
        """Return the spectra of some runs, by their indices."""
        kept = list(runs)
        return CrossSpectra(self.freq, self.ff[kept], self.fx[kept], self.xx[kept], self.averages)

    def at(self, lines: IntArray) -> "CrossSpectra":
        """Return the spectra at some of the lines, (n,) indices."""
        return CrossSpectra(
            self.freq[lines], self.ff[:, lines], self.fx[:, lines], self.xx[:, lines], self.averages
        )
