"""Distinction of resonances, common to the FRFs, from peaks of noise, which differ between FRFs."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.extraction.preprocessing.bands import Band, find_bands
from modallab.extraction.preprocessing.line_noise import has_coherence
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.preprocessing.settings import BANDS, COMMON_PEAKS


@dataclass(frozen=True)
class CommonPeaks:
    """Bands of the peaks that may be modes, with a note on the peaks that were rejected."""

    bands: tuple[Band, ...]
    """Bands of the peaks that may be modes."""
    notes: tuple[str, ...] = ()
    """Statement of the peaks that were rejected as noise."""


def find_common(responses: Responses, indicator: FloatArray, n_modes: int | None = None) -> CommonPeaks:
    """Return one band for every peak, without peaks of noise where no coherence identifies noise.

    Where the force has very little power, as that of a hammer at high frequencies, noise divided by it makes
    peaks as smooth as resonances, at other frequencies in every FRF. The distance of an FRF's nearest own
    peak, relative to half the interval between its peaks, is then uniform between 0 and 1. At a resonance it
    is about zero, also where a roving accelerometer's mass shifts the frequency a little. A range in which
    hardly any peak matches more FRFs than by chance is a range of noise; only those of its peaks are kept
    that match and that are more prominent than all unmatched peaks nearby. Without any such peak nothing is
    rejected.

    Parameters
    ----------
    responses
        From `responses_of`.
    indicator
        (n_freq,) from `mode_indicator`.
    n_modes
        Number of bands to keep, those of the most prominent peaks; None: all.

    Raises
    ------
    NoModeInBandError
        If the indicator has no prominent peak.
    """
    bands = find_bands(indicator)
    if (
        len(bands) <= COMMON_PEAKS.minimum_uncommon
        or len(responses.frfs) < COMMON_PEAKS.minimum_frfs
        or has_coherence(responses)
    ):
        return CommonPeaks(find_bands(indicator, n_modes))
    peaks = np.array([band.peak for band in bands])
    prominence, _, _ = scipy.signal.peak_prominences(np.log10(indicator), peaks)
    noise = _noise_peaks(_common_to_frfs(responses, peaks), prominence)
    if not noise.any() or noise.all():
        return CommonPeaks(find_bands(indicator, n_modes))
    common = np.flatnonzero(~noise)
    if n_modes is not None:
        common = np.sort(common[np.argsort(-prominence[common], kind="stable")[:n_modes]])
    return CommonPeaks(tuple(bands[i] for i in common), (_noise_note(responses.freq[peaks], noise),))


def _common_to_frfs(responses: Responses, peaks: IntArray) -> BoolArray:
    """Return which peaks are matched by more FRFs than by chance, (n_peaks,) boolean."""
    level = np.log10(np.maximum(np.abs(responses.mobility) ** 2, SAFE_DIVISOR)).T
    distances = np.sort(
        [_relative_distance(frf_peaks, peaks, len(responses.freq)) for frf_peaks in map(_frf_peaks, level)],
        axis=0,
    )
    n_matching = (distances[1:] < COMMON_PEAKS.match_distance).sum(
        axis=0
    )  # the nearest FRF matches in any case
    return np.asarray(
        scipy.special.bdtrc(n_matching - 1, len(distances) - 1, COMMON_PEAKS.match_distance)
        < COMMON_PEAKS.chance_probability
    )


def _frf_peaks(level: FloatArray) -> IntArray:
    return np.asarray(scipy.signal.find_peaks(level, prominence=BANDS.prominence)[0], np.int64)


def _relative_distance(frf_peaks: IntArray, peaks: IntArray, n_lines: int) -> FloatArray:
    """Return the distance of each peak from the nearest one of the FRF, over half their interval."""
    if not len(frf_peaks):
        return np.ones(len(peaks))
    position = np.searchsorted(frf_peaks, peaks)
    bounds = np.concatenate([[0], frf_peaks, [n_lines]])
    lower_bound, upper_bound = bounds[position], bounds[position + 1]
    lower_peak, upper_peak = (
        frf_peaks[np.maximum(position - 1, 0)],
        frf_peaks[np.minimum(position, len(frf_peaks) - 1)],
    )
    nearest = np.minimum(np.abs(peaks - lower_peak), np.abs(upper_peak - peaks))
    return np.asarray(2 * nearest / np.maximum(upper_bound - lower_bound, 1))


def _noise_peaks(common: BoolArray, prominence: FloatArray) -> BoolArray:
    """Return which peaks are noise, (n_peaks,) in order of frequency."""
    noise = np.zeros(len(prominence), bool)
    for i in range(len(noise)):
        for neighbours in _neighbours(i):
            uncommon = ~common[neighbours]
            if uncommon.sum() >= COMMON_PEAKS.minimum_uncommon:
                noise[i] |= not common[i] or prominence[i] <= prominence[neighbours][uncommon].max()
    return noise


def _neighbours(i: int) -> Iterable[slice]:
    return slice(max(i - COMMON_PEAKS.neighbours, 0), i), slice(i + 1, i + 1 + COMMON_PEAKS.neighbours)


def _noise_note(peaks: FloatArray, noise: BoolArray) -> str:
    lower, upper = peaks[noise][[0, -1]]
    return (
        f"{noise.sum()} peaks from {lower:g} to {upper:g} Hz were classified as noise: without coherence, "
        "peaks that are not common to the FRFs are not modes; to identify a mode there, request its band"
    )
