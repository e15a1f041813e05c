"""Noise of forces and responses, and the spectra that tell it."""

from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np
from scipy.interpolate import BSpline

from modallab.core.arrays import BoolArray, FloatArray, frozen
from modallab.diagnosis.residuals.settings import FREE_LEVELS


def noise_functions(freq: FloatArray, measured: FloatArray) -> FloatArray:
    """Return the functions (n_freq, n) whose sum is the logarithm of a noise spectrum.

    Cubic B-splines over the logarithm of frequency, constant beyond the measured lines: wide beside a
    resonance, and as near to 1/f as to white noise. A single constant where lines are few.

    Parameters
    ----------
    measured
        Frequencies of the measured lines, Hz.
    """
    return _noise_functions(freq.tobytes(), measured.tobytes())


@lru_cache(maxsize=16)
def _noise_functions(freq_bytes: bytes, measured_bytes: bytes) -> FloatArray:
    """Return `noise_functions`, the same array for the same lines: every prediction of a test needs them."""
    freq, measured = (np.frombuffer(part) for part in (freq_bytes, measured_bytes))
    positive = measured[measured > 0]
    n = FREE_LEVELS.noise_functions
    if len(positive) < n * FREE_LEVELS.lines_per_function:
        return frozen(np.ones((len(freq), 1)), float, (None, 1))
    low, high = np.log(positive[[0, -1]])
    knots = np.concatenate([[low] * 3, np.linspace(low, high, n - 2), [high] * 3])
    at = np.log(np.clip(freq, positive[0], positive[-1])).clip(low, high)
    return frozen(BSpline.design_matrix(at, knots, 3).toarray(), float, (None, n))


@dataclass(frozen=True, eq=False)
class ChannelNoise:
    """Noise of the channels, as coefficients of `noise_functions`; zero where it has none."""

    measured: FloatArray
    """(n_lines,) Hz, lines that the functions are spread over."""
    force: FloatArray | None
    """(n,) of ln(N^2/Hz), of all force channels."""
    response: FloatArray | None
    """(n, n_out) of ln((m/s^2)^2/Hz), of the response channels, run by run."""

    def force_at(self, freq: FloatArray) -> FloatArray:
        """Return the noise of the force channels, (n_freq,) N^2/Hz."""
        if self.force is None:
            return np.zeros(len(freq))
        return np.asarray(np.exp(noise_functions(freq, self.measured) @ self.force))

    def response_at(self, freq: FloatArray) -> FloatArray | float:
        """Return the noise of the response channels, (n_freq, n_out) (m/s^2)^2/Hz."""
        if self.response is None:
            return 0.0
        return np.asarray(np.exp(noise_functions(freq, self.measured) @ self.response))


@dataclass(frozen=True, eq=False)
class NoiseData:
    """Incoherent response spectra G_xx (1 - coherence), (n_freq, n_out) each."""

    freq: FloatArray
    """(n_freq,) Hz."""
    measured: FloatArray
    """(m/s^2)^2/Hz."""
    weight: FloatArray
    """Inverse variance of its logarithm; 0 where it is not used."""
    fitted: BoolArray
    """Entries that tell the noise of the force."""
    other: FloatArray
    """What is incoherent without noise, as by leakage or a nonlinear force."""
    coherent: FloatArray
    """Response to the forces."""
    gain: FloatArray
    """1/kg^2, (n_freq, n_out, n_in), squared FRFs to the forces that act at once."""
    force: FloatArray
    """N^2/Hz, (n_freq, n_out, n_in), these forces without noise."""

    def of_channels(self, channels: BoolArray) -> "NoiseData":
        """Return the data of some response channels (n_out,)."""
        by_channel = (item.name for item in fields(self) if item.name != "freq")
        return NoiseData(self.freq, **{name: getattr(self, name)[:, channels] for name in by_channel})
