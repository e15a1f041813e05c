"""Frequency lines that count, by bands: one definition for every task that reads measured FRFs."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.errors import InvalidInputError
from modallab.core.options import Options, option

Band = tuple[float, float]
MAX_BANDS = 500


@dataclass(frozen=True)
class ExcludedLines(Options):
    """Lines that are left out."""

    exclude: tuple[Band, ...] = option(
        (), unit="Hz", doc="bands, lower and upper end, whose lines are left out", max_items=MAX_BANDS
    )


@dataclass(frozen=True)
class LineOptions(ExcludedLines):
    """Lines that count."""

    bands: tuple[Band, ...] | None = option(
        None,
        unit="Hz",
        doc="bands, lower and upper end, whose lines alone count; null: all lines",
        min_items=1,
        max_items=MAX_BANDS,
    )


ALL_LINES = LineOptions()


def line_mask(
    freq: FloatArray, bands: Sequence[Band] | None = None, exclude: Sequence[Band] = ()
) -> BoolArray | None:
    """Return the mask (n_freq,) of the lines in the bands, those in excluded bands left out; None for all.

    Ends belong to their bands.

    Parameters
    ----------
    freq
        (n_freq,) Hz, rising.
    bands, exclude
        Pairs (lower, upper), Hz; `bands` None for all lines.

    Raises
    ------
    InvalidInputError
        If a lower end is not below its upper end, if a band lies outside the lines, or if no line is left.
    """
    if bands is None and not exclude:
        return None
    selected = np.ones(len(freq), bool) if bands is None else _inside(freq, bands, "bands")
    selected &= ~_inside(freq, exclude, "exclude")
    if not selected.any():
        raise InvalidInputError(
            "no line is left",
            field="exclude" if exclude else "bands",
            value=[list(band) for band in (exclude or bands or ())][:5],
            allowed=f"lines from {freq[0]:g} to {freq[-1]:g} Hz",
        )
    return selected


def _inside(freq: FloatArray, bands: Sequence[Band], name: Literal["bands", "exclude"]) -> BoolArray:
    inside = np.zeros(len(freq), bool)
    for number, (lower, upper) in enumerate(bands):
        overlaps = lower < upper and lower <= freq[-1] and upper >= freq[0]
        if not overlaps:  # NaN fails too
            raise InvalidInputError(
                f"{name}: pair {number + 1} is no band of the lines",
                field=name,
                value=[lower, upper],
                allowed=f"lower < upper, within {freq[0]:g} to {freq[-1]:g} Hz",
            )
        inside |= (freq >= lower) & (freq <= upper)
    return inside
