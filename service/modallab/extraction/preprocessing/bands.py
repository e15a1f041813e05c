"""Bands of single modes from the peaks of a mode indicator over all FRFs."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.errors import InvalidInputError, NoModeInBandError
from modallab.extraction.options import MIN_LINES
from modallab.extraction.preprocessing.settings import BANDS


@dataclass(frozen=True)
class Band:
    """Interval of the frequency axis with one mode, as indices of lines."""

    first: int
    """Index of the first line."""
    last: int
    """Index of the last line, inclusive."""
    peak: int
    """Index of the line of the peak."""


def coherent_lines(coherence: FloatArray, averages: float) -> BoolArray:
    """Return the lines at which an FRF has more coherence than pure noise, (n_freq,) boolean.

    The estimated coherence of pure noise exceeds c with probability `(1 - c)^(n - 1)` at n averages.

    Parameters
    ----------
    coherence
        (n_freq, n_frf).
    averages
        Effective number of averages.
    """
    threshold = 1 - BANDS.false_peak_probability ** (1 / max(averages - 1, 1))
    return np.asarray(coherence.max(axis=1) > min(threshold, BANDS.largest_coherence_threshold))


def mode_indicator(mobility: ComplexArray, coherent: BoolArray) -> FloatArray:
    """Return the coherent power summed over the FRFs, each normalised by its mean, (n_freq,).

    Mobility is used because resonances of equal damping have similar heights in it. Each FRF is normalised by
    its own mean power, so that a drive point does not hide the other FRFs. Lines that are not coherent are
    interpolated: a gap inside a resonance would look like two peaks.

    Parameters
    ----------
    mobility
        (n_freq, n_frf) m/(s N), multiplied by the root of the coherence.
    coherent
        (n_freq,) from `coherent_lines`.

    Raises
    ------
    NoModeInBandError
        If no FRF has power at a coherent line.
    """
    power = np.where(coherent[:, None], np.abs(mobility) ** 2, 0.0)
    mean = power.mean(axis=0)
    normalised_power: FloatArray = (power / np.where(mean > 0, mean, 1.0)).sum(axis=1)
    if not normalised_power.any():
        raise NoModeInBandError("the FRFs are zero, or without coherence at all lines", field="bands")
    lines = np.arange(len(normalised_power))
    positive = normalised_power > 0
    return np.asarray(10 ** np.interp(lines, lines[positive], np.log10(normalised_power[positive])))


def find_bands(indicator: FloatArray, n_modes: int | None = None) -> tuple[Band, ...]:
    """Return one band for every peak of the indicator, in order of frequency.

    A peak has at least the prominence of `BandSettings`. Two bands meet at the lowest line between their
    peaks.

    Parameters
    ----------
    indicator
        (n_freq,) from `mode_indicator`.
    n_modes
        Number of bands to keep, those of the most prominent peaks; None: all.

    Raises
    ------
    NoModeInBandError
        If there is no such peak.
    """
    level = np.log10(indicator)
    peaks, properties = scipy.signal.find_peaks(level, prominence=BANDS.prominence)
    if not len(peaks):
        raise NoModeInBandError("no resonance was found in the FRFs", field="bands")
    if n_modes is not None:
        peaks = np.sort(peaks[np.argsort(-properties["prominences"], kind="stable")[:n_modes]])
    return _bands_between_dips(level, peaks)


def _bands_between_dips(level: FloatArray, peaks: IntArray) -> tuple[Band, ...]:
    bounds = [0, *peaks.tolist(), len(level) - 1]
    dips = [a + int(np.argmin(level[a : b + 1])) for a, b in pairwise(bounds)]
    return tuple(Band(dips[i], dips[i + 1], int(peak)) for i, peak in enumerate(peaks))


def requested_bands(
    freq: FloatArray, indicator: FloatArray, bands: Sequence[tuple[float, float]]
) -> tuple[Band, ...]:
    """Return the bands that the user requested, in order of frequency, each with its highest peak.

    Parameters
    ----------
    freq, indicator
        (n_freq,) Hz, and from `mode_indicator`.
    bands
        Pairs (lower, upper), Hz.

    Raises
    ------
    InvalidInputError
        If a lower limit is not below its upper limit, or if a band has fewer than four lines.
    """
    requested = []
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
        requested.append(Band(first, last, _highest_peak(indicator, first, last)))
    return tuple(requested)


def _highest_peak(indicator: FloatArray, first: int, last: int) -> int:
    """Return the index of the highest peak, or of the highest line if the band has no peak."""
    inside = indicator[first : last + 1]
    peaks, _ = scipy.signal.find_peaks(inside)
    candidates = peaks if len(peaks) else np.arange(len(inside))
    return first + int(candidates[np.argmax(inside[candidates])])
