"""Which single-FRF fits may speak for a mode."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray

SURE = 0.5  # of a bandwidth or a line: a mode less surely placed may be none
PLACED = 0.1  # of a bandwidth or a line: what all FRFs together must place a mode to
FAR = 5.0  # robust standard deviations: one clean fit in a million lies so far out by chance
CLOSE = 0.02  # of a bandwidth, or of the damping: fits that agree so well are not parted further
VAGUE = 10.0  # times the usual standard error: a plain mean would inherit it
TO_SD = 1.4826  # median absolute deviation of a normal law, to its standard deviation


@dataclass(frozen=True, eq=False)
class Screening:
    """Verdict on every fit, (n_modes, n_frf).

    `unsure` fits are too inexact to use, `outlying` ones contradict the rest.
    """

    good: BoolArray
    unsure: BoolArray
    outlying: BoolArray


def screen(
    frequency: FloatArray,
    loss_factor: FloatArray,
    frequency_error: FloatArray,
    loss_factor_error: FloatArray,
    found: BoolArray,
    spacing: float,
) -> Screening:
    """Return which fits are good, all arrays (n_modes, n_frf), errors being standard errors.

    `spacing` is that of the lines, Hz.

    An FRF near a node fits noise and other modes' tails: its standard errors say so, and it is left out
    before the robust comparison of the rest.
    """
    width = loss_factor * frequency
    sure = found & (frequency_error < SURE * np.maximum(width, spacing)) & (loss_factor_error < loss_factor)
    width, damping = _median(width, sure), _median(loss_factor, sure)
    sure &= ~(
        _vague(frequency, frequency_error, CLOSE * width, sure)
        | _vague(loss_factor, loss_factor_error, CLOSE * damping, sure)
    )
    far = _far(frequency, frequency_error, CLOSE * width, sure)
    far |= _far(loss_factor, loss_factor_error, CLOSE * damping, sure)
    good = sure & ~far
    error = np.sqrt((good * frequency_error**2).sum(axis=1)) / np.maximum(good.sum(axis=1), 1)
    placed = error < PLACED * np.maximum(width, spacing)
    return Screening(good=good & placed[:, None], unsure=~sure, outlying=far)


def _vague(values: FloatArray, errors: FloatArray, floor: FloatArray, sure: BoolArray) -> BoolArray:
    """Return which errors are unusual, and wider than the values differ among themselves."""
    usual = np.maximum(VAGUE * _median(errors, sure), _scatter(values, floor, sure))
    vague: BoolArray = errors > usual[:, None]
    return vague


def _far(values: FloatArray, errors: FloatArray, floor: FloatArray, sure: BoolArray) -> BoolArray:
    away = np.abs(values - _median(values, sure)[:, None])
    far: BoolArray = sure & (away > FAR * np.hypot(_scatter(values, floor, sure)[:, None], errors))
    return far


def _scatter(values: FloatArray, floor: FloatArray, sure: BoolArray) -> FloatArray:
    """Return the robust standard deviation of each row, at least `floor`."""
    away = np.abs(values - _median(values, sure)[:, None])
    return np.maximum(TO_SD * _median(away, sure), floor)


def _median(values: FloatArray, among: BoolArray) -> FloatArray:
    """Return the median of each row over the entries that count, 0 where none does."""
    n = among.sum(axis=1)
    ranked = np.sort(np.where(among, values, np.inf), axis=1)
    rows = np.arange(len(values))
    # of an even number the two in the middle, else the same one twice
    middle = (ranked[rows, np.maximum(n - 1, 0) // 2] + ranked[rows, np.minimum(n // 2, n - (n > 0))]) / 2
    return np.asarray(np.where(n > 0, middle, 0.0))
