"""Windows of lines for single-mode fits: each follows the FRF's own peak inside the band."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.numerics import SQUARE_ROUNDING
from modallab.extraction.options import MIN_LINES
from modallab.extraction.preprocessing.bands import Band
from modallab.extraction.preprocessing.settings import FIT_WINDOWS


@dataclass(frozen=True, eq=False)
class Windows:
    """Lines of every fit, (n_modes, n_frf, n_lines): all of a window, or every k-th of a wide one."""

    index: IntArray
    """(n_modes, n_frf, n_lines) index on the frequency axis."""
    used: BoolArray
    """(n_modes, n_frf, n_lines) False where a row is padded or a line is left out."""
    ends: IntArray
    """(n_modes, n_frf, 2) first and last line, including lines left out between them."""
    stride: IntArray
    """(n_modes,) distance from one line of a window to the next, in lines."""


def place_windows(
    mobility: ComplexArray,
    indicator: FloatArray,
    bands: Sequence[Band],
    *,
    base: int,
    widths: float = 0.0,
    leave_out: int = 0,
) -> Windows:
    """Return the lines nearest to each FRF's own peak, inside the band.

    Parameters
    ----------
    mobility
        (n_freq, n_frf) m/(s N).
    indicator
        (n_freq,) from `mode_indicator`.
    bands
        One for each mode.
    base
        Number of lines of a mode whose bandwidth does not require more.
    widths
        Least width of the window in half-power bandwidths.
    leave_out
        Number of lines nearest to the peak that are not used; fewer where less than four would remain.
    """
    magnitude = np.abs(mobility)
    first, last, count, stride = (np.empty(len(bands), int) for _ in range(4))
    frf_peak = np.empty((len(bands), magnitude.shape[1]), int)
    for m, band in enumerate(bands):
        first[m], last[m] = band.first, band.last
        half_power = _interval_above(indicator, band, 0.5)
        wide = min(int(widths * (half_power[1] - half_power[0])), band.last - band.first + 1)
        stride[m] = window_stride(wide)
        count[m] = max(min(base, band.last - band.first + 1), -(-wide // stride[m]))
        frf_peak[m] = _frf_peaks(
            magnitude, band, _interval_above(indicator, band, FIT_WINDOWS.peak_search_level)
        )
    columns = np.arange(magnitude.shape[1])
    next_line, previous_line = np.minimum(frf_peak + 1, len(magnitude) - 1), np.maximum(frf_peak - 1, 0)
    # a window with an even number of lines has one more on the side of the resonance
    leans_upwards = magnitude[next_line, columns] > magnitude[previous_line, columns]
    leans_upwards &= (count % 2 == 0)[:, None]
    start = frf_peak - stride[:, None] * (count[:, None] // 2 - leans_upwards)
    length = stride * (count - 1)
    start = np.clip(start, first[:, None], (last - length)[:, None])
    offset = np.arange(count.max())
    used = np.broadcast_to(offset < count[:, None, None], (*frf_peak.shape, len(offset)))
    index = np.minimum(start[:, :, None] + stride[:, None, None] * offset, len(magnitude) - 1)
    if leave_out:
        used = without_nearest(magnitude[index, columns[None, :, None]], used, leave_out)
    return Windows(index, used, np.stack([start, start + length[:, None]], axis=2), stride)


def window_stride(n_lines: int) -> int:
    """Return the distance, in lines, of the lines of a fit whose bandwidth asks for `n_lines`.

    It is a power of two, so that the ends of a window determine it.
    """
    excess = max(n_lines - 1, 0) // FIT_WINDOWS.largest_window
    return 1 << excess.bit_length()


def without_nearest(magnitude: FloatArray, used: BoolArray, leave_out: int) -> BoolArray:
    """Return `used` without the lines nearest to the highest one, (..., n_lines); at least four remain."""
    high = np.where(used, magnitude, -1.0)
    peak = np.argmax(high, axis=-1)[..., None]
    last = magnitude.shape[-1] - 1
    next_line, previous_line = np.minimum(peak + 1, last), np.maximum(peak - 1, 0)
    leans_upwards = np.take_along_axis(high, next_line, -1) > np.take_along_axis(high, previous_line, -1)
    # the peak is shifted to the side of the resonance, so that no two lines have the same distance
    distance = np.abs(
        np.arange(last + 1) - peak - np.where(leans_upwards, FIT_WINDOWS.tie_offset, -FIT_WINDOWS.tie_offset)
    )
    rank = np.argsort(np.argsort(np.where(used, distance, np.inf), axis=-1), axis=-1)
    spare = np.clip(used.sum(axis=-1, keepdims=True) - MIN_LINES, 0, leave_out)
    return np.asarray(used & (rank >= spare))


def _interval_above(indicator: FloatArray, band: Band, level: float) -> tuple[int, int]:
    """Return the lines that bound the interval about the peak where the indicator exceeds `level` of it."""
    low = indicator < level * indicator[band.peak]
    low_before = np.flatnonzero(low[band.first : band.peak])
    low_after = np.flatnonzero(low[band.peak : band.last + 1])
    start = band.first + int(low_before[-1]) if len(low_before) else band.first
    stop = band.peak + int(low_after[0]) if len(low_after) else band.last
    return start, stop


def _frf_peaks(magnitude: FloatArray, band: Band, interval: tuple[int, int]) -> IntArray:
    """Return the line of each FRF's maximum in the interval, (n_frf,); the band's peak if it is at an end."""
    start, stop = interval
    inside = magnitude[start : stop + 1]
    highest = np.argmax(inside, axis=0)
    peaked = (highest > 0) & (highest < len(inside) - 1)
    peaks: IntArray = np.where(peaked, start + highest, band.peak)
    return peaks


def line_variance(values: ComplexArray, coherence: FloatArray, averages: float) -> FloatArray:
    """Return the variance E|error|^2 of FRF lines from coherence; infinite where nothing is coherent.

    The normalised random error `e[|H|] = sqrt((1 - g2)/(2 n_d g2))` [5.16] holds for the magnitude and, in
    radians, for the phase, so that a complex line has twice its square. The result is not smaller than the
    rounding error of the Fourier transform, which coherence does not show.

    Parameters
    ----------
    values, coherence
        FRF of any kind and its coherence, of equal shape.
    averages
        Effective number of averages.
    """
    power = np.abs(values) ** 2
    coherent = coherence > 0
    relative = np.where(coherent, (1 - coherence) / (averages * np.where(coherent, coherence, 1.0)), np.inf)
    relative = np.maximum(relative, SQUARE_ROUNDING)
    usable = coherent & (power > 0)
    return np.where(usable, power, 1.0) * np.where(usable, relative, np.inf)
