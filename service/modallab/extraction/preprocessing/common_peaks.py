"""Which peaks FRFs have in common, and which are noise: every FRF has that at other frequencies."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy.signal
import scipy.stats

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.extraction.preprocessing.bands import PROMINENCE, Band, find_bands
from modallab.extraction.preprocessing.line_noise import knows_noise
from modallab.extraction.preprocessing.responses import Responses

LEAST = 3  # FRFs: of two, neither outvotes the other
NEAR = 0.1  # of half the way between an FRF's own peaks: so near is one peak in ten of any set by chance
BY_CHANCE = 0.011  # of peaks so many FRFs have one near: of three FRFs all
BESIDE = 8  # peaks, below or above, that tell what noise does there
CROWD = 6  # of these that FRFs have not in common: fewer may be local modes


@dataclass(frozen=True)
class CommonPeaks:
    """Bands of peaks that may be modes, and in words what was left out."""

    bands: tuple[Band, ...]
    left_out: tuple[str, ...] = ()


def find_common(responses: Responses, indicator: FloatArray, n_modes: int | None = None) -> CommonPeaks:
    """Return a band for every peak, without those that are noise where no coherence tells it.

    Where the force has hardly any power, as that of a hammer at high frequencies, noise over it makes peaks
    as smooth as resonances, in every FRF others. How near an FRF has a peak of its own, in parts of the way
    between its peaks, is then any number from 0 to 1; where peaks are of one structure, or of FRFs that
    a roving mass moves a little, it is about 0. A stretch in which hardly any peak has more FRFs near than
    chance brings is one of noise; of its peaks only those are kept that have, and that stand out further
    than all others about. If none are, nothing is known of noise.

    Parameters
    ----------
    responses
        From `responses_of`.
    indicator
        (n_freq,) from `mode_indicator`.
    n_modes
        How many to keep, the most prominent ones.

    Raises
    ------
    NoModeInBandError
        If no line stands out.
    """
    bands = find_bands(indicator)
    if len(bands) <= CROWD or len(responses.frfs) < LEAST or knows_noise(responses):
        return CommonPeaks(find_bands(indicator, n_modes))
    peaks = np.array([band.peak for band in bands])
    prominence, _, _ = scipy.signal.peak_prominences(np.log10(indicator), peaks)
    noise = _noise(_shared(responses, peaks), prominence)
    if not noise.any() or noise.all():
        return CommonPeaks(find_bands(indicator, n_modes))
    common = np.flatnonzero(~noise)
    if n_modes is not None:
        common = np.sort(common[np.argsort(-prominence[common], kind="stable")[:n_modes]])
    return CommonPeaks(tuple(bands[i] for i in common), (_said(responses.freq[peaks], noise),))


def _shared(responses: Responses, peaks: IntArray) -> BoolArray:
    """Return which peaks more FRFs have than chance brings, (n_peaks,)."""
    level = np.log10(np.maximum(np.abs(responses.mobility) ** 2, 1e-300)).T
    away = np.sort([_away(own, peaks, len(responses.freq)) for own in map(_own_peaks, level)], axis=0)
    near = (away[1:] < NEAR).sum(axis=0)  # one FRF has it in any case
    return np.asarray(scipy.stats.binom.sf(near - 1, len(away) - 1, NEAR) < BY_CHANCE)


def _own_peaks(level: FloatArray) -> IntArray:
    return np.asarray(scipy.signal.find_peaks(level, prominence=PROMINENCE)[0], np.int64)


def _away(own: IntArray, peaks: IntArray, n_lines: int) -> FloatArray:
    """Return how far the nearest of an FRF's own peaks is, over half the way between those on either side."""
    if not len(own):
        return np.ones(len(peaks))
    place = np.searchsorted(own, peaks)
    ends = np.concatenate([[0], own, [n_lines]])
    below, above = ends[place], ends[place + 1]
    lower, upper = own[np.maximum(place - 1, 0)], own[np.minimum(place, len(own) - 1)]
    nearest = np.minimum(np.abs(peaks - lower), np.abs(upper - peaks))
    return np.asarray(2 * nearest / np.maximum(above - below, 1))


def _noise(shared: BoolArray, prominence: FloatArray) -> BoolArray:
    """Return which peaks are noise, (n_peaks,) in rising frequency."""
    noise = np.zeros(len(prominence), bool)
    for i in range(len(noise)):
        for near in _beside(i):
            others = ~shared[near]
            if others.sum() >= CROWD:
                noise[i] |= not shared[i] or prominence[i] <= prominence[near][others].max()
    return noise


def _beside(i: int) -> Iterable[slice]:
    return slice(max(i - BESIDE, 0), i), slice(i + 1, i + 1 + BESIDE)


def _said(peaks: FloatArray, noise: BoolArray) -> str:
    lower, upper = peaks[noise][[0, -1]]
    return (
        f"{noise.sum()} peaks from {lower:g} to {upper:g} Hz are taken for noise: no coherence tells, and "
        "FRFs have hardly any peak there in common; a mode among them is read where its band is given"
    )
