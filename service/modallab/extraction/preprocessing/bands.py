"""Where the modes are: peaks of an indicator over all FRFs, and the stretches between them."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.signal

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.errors import InvalidInputError, NoModeInBandError
from modallab.extraction.options import MIN_LINES

PROMINENCE = 0.6  # decades of power, 6 dB: neighbouring resonances dip further, random error does not
FALSE_PEAK = 0.01  # chance that noise alone shows the coherence asked of a peak


@dataclass(frozen=True)
class Band:
    """A stretch of the axis with one mode: first and last line, and the line of the peak."""

    first: int
    last: int
    peak: int


def coherent_lines(coherence: FloatArray, averages: float) -> BoolArray:
    """Return at which lines some FRF is more coherent than noise would be, (n_freq,)."""
    # coherence of pure noise exceeds c with probability (1 - c)^(n - 1)
    least = 1 - FALSE_PEAK ** (1 / max(averages - 1, 1))
    return np.asarray(coherence.max(axis=1) > min(least, 0.9))


def mode_indicator(mobility: ComplexArray, coherent: BoolArray) -> FloatArray:
    """Return coherent power summed over the FRFs, (n_freq,).

    Mobility, because resonances of like damping are alike high in it; each FRF in parts of its own
    mean, so that no drive point drowns the rest. Lines that are not coherent are bridged: a gap in a
    resonance would make two of it.

    Parameters
    ----------
    mobility
        (n_freq, n_frf), the coherent part: times the root of the coherence.
    coherent
        (n_freq,) from `coherent_lines`.
    """
    power = np.where(coherent[:, None], np.abs(mobility) ** 2, 0.0)
    mean = power.mean(axis=0)
    share: FloatArray = (power / np.where(mean > 0, mean, 1.0)).sum(axis=1)
    if not share.any():
        raise NoModeInBandError("the FRFs are zero, or nowhere coherent", field="bands")
    lines = np.arange(len(share))
    some = share > 0
    return np.asarray(10 ** np.interp(lines, lines[some], np.log10(share[some])))


def find_bands(indicator: FloatArray, n_modes: int | None = None) -> tuple[Band, ...]:
    """Return a band for every peak, in rising frequency; the `n_modes` most prominent if there are more.

    A peak stands `PROMINENCE` above the dips beside it. A band ends at the lowest line between two peaks.

    Parameters
    ----------
    indicator
        (n_freq,) from `mode_indicator`.

    Raises
    ------
    NoModeInBandError
        If no line stands out.
    """
    level = np.log10(indicator)
    peaks, shape = scipy.signal.find_peaks(level, prominence=PROMINENCE)
    if not len(peaks):
        raise NoModeInBandError("no resonance stands out of the FRFs", field="bands")
    if n_modes is not None:
        peaks = np.sort(peaks[np.argsort(-shape["prominences"], kind="stable")[:n_modes]])
    return _between(level, peaks)


def _between(level: FloatArray, peaks: IntArray) -> tuple[Band, ...]:
    ends = [0, *peaks.tolist(), len(level) - 1]
    dips = [a + int(np.argmin(level[a : b + 1])) for a, b in pairwise(ends)]
    return tuple(Band(dips[i], dips[i + 1], int(peak)) for i, peak in enumerate(peaks))


def given_bands(
    freq: FloatArray, indicator: FloatArray, bands: Sequence[tuple[float, float]]
) -> tuple[Band, ...]:
    """Return the bands the user asked for, in rising frequency, each with its highest peak.

    Parameters
    ----------
    freq, indicator
        (n_freq,) Hz and from `mode_indicator`.
    bands
        Pairs (lower, upper), Hz.

    Raises
    ------
    InvalidInputError
        If a band is upside down or holds fewer than four lines.
    """
    found = []
    for number, (lower, upper) in enumerate(sorted(bands)):
        inside = np.flatnonzero((freq >= lower) & (freq <= upper))
        if not lower < upper or len(inside) < MIN_LINES:
            raise InvalidInputError(
                f"band {number}, {lower:g} to {upper:g} Hz, holds {len(inside)} lines",
                field="bands",
                value=f"[{lower:g}, {upper:g}]",
                allowed=f"lower < upper with at least {MIN_LINES} lines between",
            )
        first, last = int(inside[0]), int(inside[-1])
        found.append(Band(first, last, _peak(indicator, first, last)))
    return tuple(found)


def _peak(indicator: FloatArray, first: int, last: int) -> int:
    """Return the highest line that is a peak, or the highest line if the band only slopes."""
    inside = indicator[first : last + 1]
    peaks, _ = scipy.signal.find_peaks(inside)
    candidates = peaks if len(peaks) else np.arange(len(inside))
    return first + int(candidates[np.argmax(inside[candidates])])
