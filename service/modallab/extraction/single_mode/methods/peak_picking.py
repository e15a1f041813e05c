"""Peak picking: the highest line and how wide the peak is at half its power."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.extraction.single_mode.lines import Lines, conclude, one_row, scale
from modallab.extraction.single_mode.method import (
    EXTRACTION_METHODS,
    ModeFits,
    SingleModeMethod,
    in_blocks,
)

TINY = 1e-100


@in_blocks
def peak_picking(freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> ModeFits:
    """Resonance at the highest line, damping from the half-power points, constant from the height.

    The plain method that the others are held against. `omega_r` is the line of the greatest |alpha|; with
    omega_a, omega_b where |alpha|^2 falls to half of that, straight lines being drawn between the lines,
    `eta = (omega_a^2 - omega_b^2)/(2 omega_r^2)` and `A = i eta omega_r^2 alpha(omega_r)`. A side on which
    the response does not fall so far is taken as the mirror image of the other.

    It is biased, whatever the noise: by up to half a line in frequency; the true peak between the lines is
    missed, so that a resonance d from its nearest line and w from its half-power points looks
    `sqrt(w^2 + 2 d^2)` wide; a residual counts as part of the peak. `quality` holds what the first two come
    to, root mean square over all places of the resonance between lines, in % of frequency and loss factor.

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
    below, above = _half_power(lines, peak)
    width = (above - below) / 2
    # damping turns the response clockwise; an unstable mode is as high and as wide
    width = np.where(_clockwise(lines, peak), width, -width)
    eigenvalue = at + 1j * width
    spacing = _spacing(lines, peak)
    stiffness = np.maximum(lines.centre + lines.half * at, TINY)
    quality = {
        # half of the relative error of omega^2; an offset is uniform over one line: its square is 1/12
        "frequency_bias": 100 * spacing * lines.half / np.sqrt(12) / 2 / stiffness,
        "loss_factor_bias": 100 * spacing**2 / np.sqrt(80) / np.maximum(width**2, TINY),
    }
    fits = conclude(lines, eigenvalue, 1j * width * top, np.zeros_like(top), quality)
    # what the other lines miss is bias, and must not pass for the random error of the two that were read
    return replace(fits, misfit=np.zeros_like(fits.misfit))


def peak_picking_plot(
    freq: FloatArray, frf: ComplexArray, weight: FloatArray
) -> dict[str, FloatArray | ComplexArray]:
    """The magnitude, its highest line, and the two points of half its power."""
    lines, x, points = one_row(freq, frf, weight)
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
    """Return |z|^2, (n_fits, n_lines), below any other where a line is not used."""
    return np.where(lines.weight > 0, lines.z.real**2 + lines.z.imag**2, -1.0)


def _peak(lines: Lines) -> IntArray:
    return np.asarray(np.argmax(_power(lines), axis=1))


def _half_power(lines: Lines, peak: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return where the power has fallen to half below and above the peak, on the scale of x, (n_fits,)."""
    below, fell_below = _crossing(lines, peak, -1)
    above, fell_above = _crossing(lines, peak, 1)
    at = lines.x[np.arange(len(peak)), peak]
    # with neither there is no width, hence no mode
    mirrored_below = np.where(fell_above, 2 * at - above, at)
    mirrored_above = np.where(fell_below, 2 * at - below, at)
    return np.where(fell_below, below, mirrored_below), np.where(fell_above, above, mirrored_above)


def _crossing(lines: Lines, peak: IntArray, side: int) -> tuple[FloatArray, BoolArray]:
    """Return where the power first falls to half on one side of the peak, and whether it does."""
    power, used = _power(lines), lines.weight > 0
    row, order = np.arange(len(peak)), np.arange(power.shape[1])
    away = side * (order - peak[:, None])
    half = power[row, peak] / 2
    n = power.shape[1]
    outside = np.where(used & (away > 0) & (power <= half[:, None]), away, n).min(axis=1, initial=n)
    fell = outside < n
    inside = np.where(used & (away >= 0) & (away < outside[:, None]), away, 0).max(axis=1, initial=0)
    low, high = np.where(fell, peak + side * outside, peak), peak + side * inside
    drop = power[row, high] - power[row, low]
    share = (power[row, high] - half) / np.where(fell, drop, 1.0)
    place = lines.x[row, high] + share * (lines.x[row, low] - lines.x[row, high])
    return np.where(fell, place, 0.0), fell


def _clockwise(lines: Lines, peak: IntArray) -> BoolArray:
    """Return whether the response turns clockwise through the peak, from the used lines beside it."""
    below, above = _neighbours(lines, peak)
    row = np.arange(len(peak))
    top = lines.z[row, peak]
    # each step is less than half a turn, what is across the peak may be more
    steps = top * lines.z[row, below].conj(), lines.z[row, above] * top.conj()
    return np.asarray(sum(np.angle(step) for step in steps) < 0)


def _neighbours(lines: Lines, peak: IntArray) -> tuple[IntArray, IntArray]:
    """Return the used lines next to the peak, or the peak itself where there is none."""
    order, used = np.arange(lines.x.shape[1]), lines.weight > 0
    left, right = used & (order < peak[:, None]), used & (order > peak[:, None])
    below = np.where(left, order, -1).max(axis=1, initial=-1)
    above = np.where(right, order, len(order)).min(axis=1, initial=len(order))
    return np.where(below < 0, peak, below), np.where(above == len(order), peak, above)


def _spacing(lines: Lines, peak: IntArray) -> FloatArray:
    """Return the distance of lines at the peak, on the scale of x, (n_fits,)."""
    below, above = _neighbours(lines, peak)
    row = np.arange(len(peak))
    return np.asarray((lines.x[row, above] - lines.x[row, below]) / np.maximum(above - below, 1))


EXTRACTION_METHODS.register("peak_picking")(
    SingleModeMethod(fit=peak_picking, plot=peak_picking_plot, exact=False)
)
