"""Peak picking: highest line and half-power bandwidth."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.numerics import SAFE_SQUARED_DIVISOR
from modallab.extraction.single_mode.lines import Lines, physical_fits, scale, single_window
from modallab.extraction.single_mode.method import (
    EXTRACTION_METHODS,
    ModeFits,
    SingleModeMethod,
    in_blocks,
)


@in_blocks
def peak_picking(freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> ModeFits:
    """Resonance at the highest line, damping from the half-power points, constant from the height.

    It is the elementary method for comparison with the others. `omega_r` is the line of the greatest |alpha|;
    with omega_a, omega_b where |alpha|^2 falls to half of that, by linear interpolation between lines, `eta =
    (omega_a^2 - omega_b^2)/(2 omega_r^2)` and `A = i eta omega_r^2 alpha(omega_r)`. A side on which the
    response does not fall so far is taken as the mirror image of the other.

    It is biased even without noise. The frequency is wrong by up to half a line. The true peak between lines
    is missed, so that a resonance at distance d from its nearest line and w from its half-power points seems
    `sqrt(w^2 + 2 d^2)` wide. A residual counts as part of the peak. `quality` contains the first two biases,
    root mean square over all positions of the resonance between lines, in % of frequency and loss factor.

    Parameters
    ----------
    freq, frf, weight
        As `ExtractionMethod`.

    References
    ----------
    Ewins, D. J. (1984), Modal Testing, chapter 4.
    """
    lines = scale(freq, frf, weight)
    peak = _peak(lines)
    row = np.arange(len(lines.x))
    at, top = lines.x[row, peak], lines.z[row, peak]
    lower, upper = _half_power(lines, peak)
    width = (upper - lower) / 2
    # damping makes the phase fall; an unstable mode has the same height and width
    width = np.where(_clockwise(lines, peak), width, -width)
    eigenvalue = at + 1j * width
    spacing = _spacing(lines, peak)
    stiffness = np.maximum(lines.centre + lines.half * at, SAFE_SQUARED_DIVISOR)
    quality = {
        # half of the relative error of omega^2; an offset is uniform over one line, with variance 1/12
        "frequency_bias": 100 * spacing * lines.half / np.sqrt(12) / 2 / stiffness,
        "loss_factor_bias": 100 * spacing**2 / np.sqrt(80) / np.maximum(width**2, SAFE_SQUARED_DIVISOR),
    }
    fits = physical_fits(lines, eigenvalue, 1j * width * top, np.zeros_like(top), quality)
    # the misfit of the other lines is bias and is not included in the random error
    return replace(fits, misfit=np.zeros_like(fits.misfit))


def peak_picking_plot(
    freq: FloatArray, frf: ComplexArray, weight: FloatArray
) -> dict[str, FloatArray | ComplexArray]:
    """Return the magnitude, its highest line, and the two half-power points."""
    lines, x, points = single_window(freq, frf, weight)
    peak = _peak(lines)
    crossings = np.concatenate(_half_power(lines, peak))
    top = np.abs(points[peak])
    return {
        "x": x,
        "magnitude": np.abs(points),
        "x_peak": x[peak],
        "peak": top,
        "x_half": lines.centre + lines.half * crossings,
        "half": np.repeat(top / np.sqrt(2), 2),
    }


def _power(lines: Lines) -> FloatArray:
    """Return |z|^2, (n_fits, n_lines), negative where a line is not used."""
    return np.where(lines.weight > 0, lines.z.real**2 + lines.z.imag**2, -1.0)


def _peak(lines: Lines) -> IntArray:
    return np.asarray(np.argmax(_power(lines), axis=1))


def _half_power(lines: Lines, peak: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the half-power points below and above the peak, on the scale of x, each (n_fits,)."""
    lower, lower_reached = _crossing(lines, peak, -1)
    upper, upper_reached = _crossing(lines, peak, 1)
    at = lines.x[np.arange(len(peak)), peak]
    # without either crossing the width is zero, hence no mode
    mirrored_lower = np.where(upper_reached, 2 * at - upper, at)
    mirrored_upper = np.where(lower_reached, 2 * at - lower, at)
    return np.where(lower_reached, lower, mirrored_lower), np.where(upper_reached, upper, mirrored_upper)


def _crossing(lines: Lines, peak: IntArray, side: int) -> tuple[FloatArray, BoolArray]:
    """Return where the power first falls to half on one side of the peak, and whether it does."""
    power, used = _power(lines), lines.weight > 0
    row, order = np.arange(len(peak)), np.arange(power.shape[1])
    offset = side * (order - peak[:, None])
    half = power[row, peak] / 2
    n = power.shape[1]
    outside = np.where(used & (offset > 0) & (power <= half[:, None]), offset, n).min(axis=1, initial=n)
    reached = outside < n
    inside = np.where(used & (offset >= 0) & (offset < outside[:, None]), offset, 0).max(axis=1, initial=0)
    low, high = np.where(reached, peak + side * outside, peak), peak + side * inside
    drop = power[row, high] - power[row, low]
    share = (power[row, high] - half) / np.where(reached, drop, 1.0)
    place = lines.x[row, high] + share * (lines.x[row, low] - lines.x[row, high])
    return np.where(reached, place, 0.0), reached


def _clockwise(lines: Lines, peak: IntArray) -> BoolArray:
    """Return whether the response runs clockwise through the peak, from the used lines beside it."""
    lower, upper = _neighbours(lines, peak)
    row = np.arange(len(peak))
    top = lines.z[row, peak]
    # each step is less than half a turn, their sum may be more
    steps = top * lines.z[row, lower].conj(), lines.z[row, upper] * top.conj()
    return np.asarray(sum(np.angle(step) for step in steps) < 0)


def _neighbours(lines: Lines, peak: IntArray) -> tuple[IntArray, IntArray]:
    """Return the used lines next to the peak, or the peak itself where there is none."""
    order, used = np.arange(lines.x.shape[1]), lines.weight > 0
    below_peak, above_peak = used & (order < peak[:, None]), used & (order > peak[:, None])
    lower = np.where(below_peak, order, -1).max(axis=1, initial=-1)
    upper = np.where(above_peak, order, len(order)).min(axis=1, initial=len(order))
    return np.where(lower < 0, peak, lower), np.where(upper == len(order), peak, upper)


def _spacing(lines: Lines, peak: IntArray) -> FloatArray:
    """Return the distance between lines at the peak, on the scale of x, (n_fits,)."""
    lower, upper = _neighbours(lines, peak)
    row = np.arange(len(peak))
    return np.asarray((lines.x[row, upper] - lines.x[row, lower]) / np.maximum(upper - lower, 1))


EXTRACTION_METHODS.register("peak_picking")(
    SingleModeMethod(fit=peak_picking, plot=peak_picking_plot, exact=False)
)
