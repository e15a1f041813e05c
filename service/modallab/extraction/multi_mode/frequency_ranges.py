"""Frequency ranges of global methods, and the orders of their stabilisation charts."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import NoModeInBandError
from modallab.extraction.multi_mode.chart_settings import CHART
from modallab.extraction.options import MOST_ORDER, GlobalOptions
from modallab.extraction.preprocessing.bands import Band, find_bands, requested_bands
from modallab.extraction.preprocessing.common_peaks import CommonPeaks, find_common
from modallab.extraction.preprocessing.responses import Responses


@dataclass(frozen=True)
class FrequencyRanges:
    """Lines of each range, in order of frequency, with the reason."""

    ranges: tuple[slice, ...]
    why: str
    left_out: tuple[str, ...] = ()

    def description(self, freq: FloatArray) -> str:
        """Return the ranges as text; `freq` (n_freq,) Hz."""
        spans = ", ".join(f"{freq[lines][0]:g} to {freq[lines][-1]:g} Hz" for lines in self.ranges)
        return f"{spans}: {self.why}"


@dataclass(frozen=True, eq=False)
class Chart:
    """Lines of a range, and the orders of its stabilisation chart."""

    lines: slice
    orders: IntArray
    why: str


def find_frequency_ranges(
    responses: Responses, indicator: FloatArray, bands: Sequence[tuple[float, float]] | None
) -> FrequencyRanges:
    """Return the lines of each range; adjacent bands are merged.

    Parameters
    ----------
    responses
        From `responses_of`.
    indicator
        (n_freq,) from `mode_indicator`.
    bands
        Requested pairs (lower, upper), Hz. By default all lines from the first coherent one to the last, or,
        where only peaks distinguish noise, the bands of the peaks that are not noise.
    """
    if bands is not None:
        return FrequencyRanges(_joined(requested_bands(responses.freq, indicator, bands)), "as requested")
    peaks = _common(responses, indicator)
    if peaks.notes:
        return FrequencyRanges(_joined(peaks.bands), "peaks that FRFs have in common", peaks.notes)
    coherent_lines = np.flatnonzero(responses.coherent)
    return FrequencyRanges(
        (slice(int(coherent_lines[0]), int(coherent_lines[-1]) + 1),), "all lines that are more than noise"
    )


def _common(responses: Responses, indicator: FloatArray) -> CommonPeaks:
    try:
        return find_common(responses, indicator)
    except NoModeInBandError:  # poles may be there without a peak
        return CommonPeaks(())


def _joined(bands: Sequence[Band]) -> tuple[slice, ...]:
    bounds = [0, *(n + 1 for n, (a, b) in enumerate(pairwise(bands)) if b.first > a.last + 1), len(bands)]
    return tuple(
        slice(bands[a].first, max(band.last for band in bands[a:b]) + 1) for a, b in pairwise(bounds) if a < b
    )


def orders_of(indicator: FloatArray, options: GlobalOptions) -> tuple[IntArray, str]:
    """Return the orders of the chart of a range, (n_orders,) ascending, with the reason."""
    limit = max((len(indicator) - 1) // CHART.lines_per_order, CHART.smallest_limit)
    if options.max_order is not None:
        top, why = min(options.max_order, limit), "as requested"
    else:
        peaks = _n_peaks(indicator)
        desired_order = CHART.orders_per_peak * peaks + CHART.residual_orders
        top = min(desired_order, limit, MOST_ORDER)
        why = (
            f"{CHART.orders_per_peak} for each of {peaks} peaks and {CHART.residual_orders} for residual"
            " terms"
        )
        if top == MOST_ORDER < desired_order:
            why += f", at most {MOST_ORDER}; narrower bands with fewer peaks have up to as many orders each"
    if top == limit:
        why += f", at most one for {CHART.lines_per_order} of the {len(indicator)} lines"
    return np.arange(2, top + 1), f"{top}: {why}"


def _n_peaks(indicator: FloatArray) -> int:
    try:
        return len(find_bands(indicator))
    except NoModeInBandError:
        return 1
