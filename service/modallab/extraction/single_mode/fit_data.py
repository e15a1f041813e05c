"""Lines of the single-mode fits of every mode in every FRF."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.preprocessing.fit_windows import Windows
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.extraction.single_mode.settings import SINGLE_MODE_FIT


@dataclass(frozen=True, eq=False)
class FitData:
    """Lines of every fit, (n_modes, n_frf, n_lines)."""

    freq: FloatArray
    """Hz."""
    receptance: ComplexArray
    """m/N."""
    weight: FloatArray
    """(N/m)^2, one over E|error|^2; 0 for a line that is not used."""
    spacing: float
    """Hz, frequency resolution."""
    leakage: WindowLeakage | None
    """Leakage of the window; None without leakage."""
    drive: int | None
    """Index of the drive-point FRF; None if there is none."""

    @property
    def x(self) -> FloatArray:
        """omega^2, (rad/s)^2."""
        return (2 * np.pi * self.freq) ** 2


def window_data(
    freq: FloatArray,
    receptance: ComplexArray,
    variance: FloatArray,
    windows: Windows,
    leakage: WindowLeakage | None,
    drive: int | None,
) -> FitData:
    """Return the lines inside the windows.

    Leaked lines have their largest errors where the response is highest, in proportion to its square: with
    the setting `leakage_error` at the peak, the fit depends on the flanks, and the correction converges for
    modes down to 0.1 lines wide.

    Parameters
    ----------
    freq
        (n_freq,) Hz.
    receptance, variance
        (n_freq, n_frf) m/N, and E|error|^2.
    windows
        From `place_windows`.
    leakage
        Of the window; None without leakage.
    drive
        Index of the drive-point FRF; None if there is none.
    """
    column = np.arange(receptance.shape[1])[None, :, None]
    values = receptance[windows.index, column]
    noise = variance[windows.index, column]
    if leakage is not None:
        inside = (
            windows.index <= windows.ends[:, :, 1:]
        )  # includes lines left out, which give the peak height
        power = np.where(inside, np.abs(values) ** 2, 0.0)
        peak = power.max(axis=2, keepdims=True)
        noise = noise + SINGLE_MODE_FIT.leakage_error**2 * power * (power / np.where(peak > 0, peak, 1.0))
    usable = windows.used & np.isfinite(noise) & (noise > 0)
    weight = np.where(usable, 1 / np.where(usable, noise, 1.0), 0.0)
    spacing = float(np.median(np.diff(freq)))
    return FitData(freq[windows.index], values, weight, spacing, leakage, drive)
