"""Which lines each fit takes: a window that follows every FRF's own peak inside the band."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.extraction.options import MIN_LINES
from modallab.extraction.preprocessing.bands import Band

MOST_LINES = 96  # unless more are asked for: beyond, Dobson's pairs cost more than the lines add
REACH = 0.01  # an FRF's own peak is looked for where the indicator is above this part of its peak


@dataclass(frozen=True, eq=False)
class Windows:
    """Lines of every fit, (n_modes, n_frf, n_lines); `used` is False where a row is padded."""

    index: IntArray
    used: BoolArray
    ends: IntArray  # (n_modes, n_frf, 2) first and last line, whatever is left out between them


def place_windows(
    mobility: ComplexArray,
    indicator: FloatArray,
    bands: Sequence[Band],
    *,
    base: int,
    widths: float = 0.0,
    leave_out: int = 0,
) -> Windows:
    """Return the lines nearest each FRF's own peak, kept inside the band.

    Parameters
    ----------
    mobility
        (n_freq, n_frf).
    indicator
        (n_freq,).
    bands
        One a mode.
    base
        Number of lines for a mode that is not wider.
    widths
        Half-power bandwidths that the lines span at least.
    leave_out
        How many of the lines, those nearest the peak, are not used; fewer where too few would be left.
    """
    size = np.abs(mobility)
    first, last, count = (np.empty(len(bands), int) for _ in range(3))
    own = np.empty((len(bands), size.shape[1]), int)
    for m, band in enumerate(bands):
        first[m], last[m] = band.first, band.last
        wide = _around(indicator, band, 0.5)
        least = max(base, min(int(widths * (wide[1] - wide[0])), MOST_LINES))
        count[m] = min(least, band.last - band.first + 1)
        own[m] = _own_peaks(size, band, _around(indicator, band, REACH))
    columns = np.arange(size.shape[1])
    above, below = np.minimum(own + 1, len(size) - 1), np.maximum(own - 1, 0)
    # an even window leans to the side where the resonance is
    lean = size[above, columns] > size[below, columns]
    start = own - count[:, None] // 2 + (lean & (count % 2 == 0)[:, None])
    start = np.clip(start, first[:, None], last[:, None] - count[:, None] + 1)
    offset = np.arange(count.max())
    used = np.broadcast_to(offset < count[:, None, None], (*own.shape, len(offset)))
    index = np.minimum(start[:, :, None] + offset, len(size) - 1)
    if leave_out:
        used = without_nearest(size[index, columns[None, :, None]], used, leave_out)
    ends = np.stack([start, start + count[:, None] - 1], axis=2)
    return Windows(index, used, ends)


def without_nearest(size: FloatArray, used: BoolArray, leave_out: int) -> BoolArray:
    """Return `used` without the lines nearest the highest, all (..., n_lines); at least four stay."""
    high = np.where(used, size, -1.0)
    peak = np.argmax(high, axis=-1)[..., None]
    last = size.shape[-1] - 1
    above, below = np.minimum(peak + 1, last), np.maximum(peak - 1, 0)
    higher_above = np.take_along_axis(high, above, -1) > np.take_along_axis(high, below, -1)
    # a quarter of a line to the side where the resonance is, so that no two lines are as near
    away = np.abs(np.arange(last + 1) - peak - np.where(higher_above, 0.25, -0.25))
    rank = np.argsort(np.argsort(np.where(used, away, np.inf), axis=-1), axis=-1)
    spare = np.clip(used.sum(axis=-1, keepdims=True) - MIN_LINES, 0, leave_out)
    return np.asarray(used & (rank >= spare))


def _around(indicator: FloatArray, band: Band, part: float) -> tuple[int, int]:
    """Return the lines that bound the run in which the indicator holds `part` of its peak."""
    low = indicator < part * indicator[band.peak]
    below = np.flatnonzero(low[band.first : band.peak])
    above = np.flatnonzero(low[band.peak : band.last + 1])
    start = band.first + int(below[-1]) if len(below) else band.first
    stop = band.peak + int(above[0]) if len(above) else band.last
    return start, stop


def _own_peaks(size: FloatArray, band: Band, reach: tuple[int, int]) -> IntArray:
    """Return each FRF's highest line within reach, or the band's peak where the FRF has none there."""
    start, stop = reach
    inside = size[start : stop + 1]
    highest = np.argmax(inside, axis=0)
    peaked = (highest > 0) & (highest < len(inside) - 1)
    own: IntArray = np.where(peaked, start + highest, band.peak)
    return own


def line_variance(values: ComplexArray, coherence: FloatArray, averages: float) -> FloatArray:
    """Return E|error|^2 of FRF lines from coherence and averages; infinite where nothing is coherent.

    `e[|H|] = sqrt((1 - g2)/(2 n_d g2))` [5.16], and as much for the phase, so that a complex line has
    twice its square. Floored at the rounding of the transform, which no coherence shows.
    """
    size = np.abs(values) ** 2
    some = coherence > 0
    relative = np.where(some, (1 - coherence) / (averages * np.where(some, coherence, 1.0)), np.inf)
    relative = np.maximum(relative, 1e-16)
    usable = some & (size > 0)
    return np.where(usable, size, 1.0) * np.where(usable, relative, np.inf)
