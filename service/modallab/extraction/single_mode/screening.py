"""Screening of single-FRF fits: imprecise fits and outliers."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.extraction.single_mode.settings import SCREENING


@dataclass(frozen=True, eq=False)
class Screening:
    """Acceptance of every fit; every array (n_modes, n_frf)."""

    good: BoolArray
    """True for fits that represent the mode."""
    unsure: BoolArray
    """True for fits that are too imprecise."""
    outlying: BoolArray
    """True for fits that contradict the others."""


def screen(
    frequency: FloatArray,
    loss_factor: FloatArray,
    frequency_error: FloatArray,
    loss_factor_error: FloatArray,
    has_mode: BoolArray,
    spacing: float,
) -> Screening:
    """Return which fits are accepted.

    An FRF near a node fits noise and other modes: its standard errors show this, and it is rejected before
    the robust comparison of the others.

    Parameters
    ----------
    frequency, loss_factor, frequency_error, loss_factor_error
        (n_modes, n_frf), Hz, with standard errors.
    identified
        (n_modes, n_frf) True where a fit has a mode.
    spacing
        Hz, frequency resolution.
    """
    width = loss_factor * frequency
    precise = (
        has_mode
        & (frequency_error < SCREENING.largest_error * np.maximum(width, spacing))
        & (loss_factor_error < loss_factor)
    )
    width, damping = _median(width, precise), _median(loss_factor, precise)
    precise &= ~(
        _imprecise(frequency, frequency_error, SCREENING.smallest_scatter * width, precise)
        | _imprecise(loss_factor, loss_factor_error, SCREENING.smallest_scatter * damping, precise)
    )
    outlying = _outlying(frequency, frequency_error, SCREENING.smallest_scatter * width, precise)
    outlying |= _outlying(loss_factor, loss_factor_error, SCREENING.smallest_scatter * damping, precise)
    good = precise & ~outlying
    error = np.sqrt((good * frequency_error**2).sum(axis=1)) / np.maximum(good.sum(axis=1), 1)
    located = error < SCREENING.largest_mean_error * np.maximum(width, spacing)
    return Screening(good=good & located[:, None], unsure=~precise, outlying=outlying)


def _imprecise(values: FloatArray, errors: FloatArray, floor: FloatArray, precise: BoolArray) -> BoolArray:
    """Return which errors are unusually large, and larger than the scatter of the values."""
    limit = np.maximum(SCREENING.imprecision * _median(errors, precise), _scatter(values, floor, precise))
    imprecise: BoolArray = errors > limit[:, None]
    return imprecise


def _outlying(values: FloatArray, errors: FloatArray, floor: FloatArray, precise: BoolArray) -> BoolArray:
    """Return which values are far from the median, in robust standard deviations."""
    deviation = np.abs(values - _median(values, precise)[:, None])
    outlying: BoolArray = precise & (
        deviation > SCREENING.outlier_deviations * np.hypot(_scatter(values, floor, precise)[:, None], errors)
    )
    return outlying


def _scatter(values: FloatArray, floor: FloatArray, precise: BoolArray) -> FloatArray:
    """Return the robust standard deviation of each row, at least `floor`."""
    deviation = np.abs(values - _median(values, precise)[:, None])
    return np.maximum(SCREENING.mad_to_deviation * _median(deviation, precise), floor)


def _median(values: FloatArray, among: BoolArray) -> FloatArray:
    """Return the median of each row over the entries of `among`, 0 where there are none."""
    n = among.sum(axis=1)
    ranked = np.sort(np.where(among, values, np.inf), axis=1)
    rows = np.arange(len(values))
    # the two middle values of an even number; the same value twice of an odd number
    middle = (ranked[rows, np.maximum(n - 1, 0) // 2] + ranked[rows, np.minimum(n // 2, n - (n > 0))]) / 2
    return np.asarray(np.where(n > 0, middle, 0.0))
