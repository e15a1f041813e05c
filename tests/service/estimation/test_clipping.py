"""Tests of the spectra of clipped Gaussian signals."""

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.estimation.clipping import clipped_power, clipped_spectra
from modallab.estimation.spectra import CrossSpectra

N_LINES, SPACING = 201, 2.0
SAMPLE_RATE = 4 * (N_LINES - 1) * SPACING  # above six times the band no third order would be aliased


def clipped(xx: FloatArray, level: float) -> CrossSpectra:
    """Return the spectra of one force, and of a response that is clipped at some standard deviations."""
    freq = np.arange(N_LINES, dtype=np.float64) * SPACING
    one = np.ones((1, N_LINES, 1, 1), np.complex128)
    spectra = CrossSpectra(freq, one, np.zeros_like(one), xx[None, :, None], 100.0)
    rms = np.sqrt(SPACING * xx.sum())
    return clipped_spectra(spectra, np.array([[np.inf, level * rms]]), np.zeros((1, 2)), SAMPLE_RATE)


@pytest.mark.parametrize("level", [1.3, 3.0, 5.0])
def test_auto_spectra_are_never_negative(level: float) -> None:
    # Power in one line: its distortion is in multiples of that frequency, all else is rounding of the FFT.
    xx = 1e-24 + 1.0 * (np.arange(N_LINES) == 60)
    assert (clipped(xx, level).xx >= 0).all()


@pytest.mark.parametrize("level", [0.5, 1.3, 3.0])
def test_power_in_the_band_is_at_most_that_of_the_clipped_signal(level: float) -> None:
    xx = np.exp(-(((np.arange(N_LINES) - 60) / 2.0) ** 2))
    power = SPACING * float(clipped(xx, level).xx.sum())
    whole = float(clipped_power(np.array(level))) * SPACING * float(xx.sum())
    # Harmonics fall outside the band, a few per cent of the power (a square wave has 19 % in them).
    assert 0.85 * whole < power <= whole * (1 + 1e-9)
