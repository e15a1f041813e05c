"""Dobson's method: straight lines through the slopes of difference quotients."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import UNIT_ROUNDING
from modallab.extraction.options import DistantLinesOptions
from modallab.extraction.single_mode.lines import (
    Lines,
    mean_residual,
    physical_fits,
    scale,
    single_window,
    weighted_line,
)
from modallab.extraction.single_mode.method import (
    EXTRACTION_METHODS,
    ModeFits,
    SingleModeMethod,
    in_blocks,
)
from modallab.extraction.single_mode.settings import DOBSON


@in_blocks
def dobson(freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> ModeFits:
    """Straight lines through difference quotients, from which a constant residual cancels.

    With a reference line W, `Delta = (omega^2 - W^2) / (alpha(omega) - alpha(W))` is a straight line in
    omega^2 with slope `u W^2 + v`, `u = 1/A`, `v = -lambda_r/A`. Complex slopes are fitted directly, so that
    real and imaginary modal constants need no separate treatment.

    Parameters
    ----------
    freq, frf, weight
        As `ExtractionMethod`.

    References
    ----------
    Dobson, B. J. (1987). A straight-line technique for extracting modal properties from frequency
    response data. Mechanical Systems and Signal Processing 1, 29-40. 1992 thesis, appendix F.
    """
    lines = scale(freq, frf, weight)
    delta, final = _quotients(lines)
    slope, _, inverse_variance = _slopes(lines.x, delta, final)
    eigenvalue, constant = _mode(lines.x, slope, inverse_variance)
    return physical_fits(lines, eigenvalue, constant, mean_residual(lines, eigenvalue, constant))


def dobson_plot(
    freq: FloatArray, frf: ComplexArray, weight: FloatArray
) -> dict[str, FloatArray | ComplexArray]:
    """Return the difference quotients of every reference line with their fits, and the slopes with theirs.

    `delta` (n_lines, n_lines - 1), one row for each reference; `slopes` (n_lines,).
    """
    lines, x, points = single_window(freq, frf, weight)
    delta, final = _quotients(lines)
    slope, level, inverse_variance = _slopes(lines.x, delta, final)
    u, v, _ = weighted_line(lines.x, slope, inverse_variance)
    fitted_lines = slope[0, :, None] * lines.x[0] + level[0, :, None]
    off_diagonal = ~np.eye(len(x), dtype=bool)
    shape = (len(x), len(x) - 1)
    scale_of_delta = lines.half / lines.size
    return {
        "x": x,
        "points": points,
        "x_delta": np.broadcast_to(x, off_diagonal.shape)[off_diagonal].reshape(shape),
        "delta": delta[0][off_diagonal].reshape(shape) * scale_of_delta,
        "delta_lines": fitted_lines[off_diagonal].reshape(shape) * scale_of_delta,
        "slopes": slope[0] / lines.size,
        "slope_line": (u * lines.x[0] + v) / lines.size,
    }


def _quotients(lines: Lines) -> tuple[ComplexArray, FloatArray]:
    """Return Delta and its weights, (n_fits, n_lines, n_lines), references along the second axis."""
    x, used = lines.x, lines.weight > 0
    noise = np.where(used, 1 / np.where(used, lines.weight, 1.0), np.inf)
    pair_weight = 1 / (noise[:, :, None] + noise[:, None, :])
    dx = x[:, :, None] - x[:, None, :]
    dz = lines.z[:, :, None] - lines.z[:, None, :]
    square, power = dx**2, dz.real**2 + dz.imag**2
    inverse = 1 / np.where(power > 0, power, np.inf)
    delta = np.asarray(dz.conj() * (dx * inverse), complex)
    # an error n of a line changes Delta by Delta^2 n / dx; the first iteration takes Delta from the noisy
    # quotients, later ones from the fit
    trust = np.where(power > 0, pair_weight * square, 0.0)
    weight = power * power
    weight *= pair_weight / np.where(square > 0, square, np.inf)
    for _ in range(DOBSON.weight_iterations - 1):
        slope, _, inverse_variance = _slopes(x, delta, weight)
        gap = _mode(x, slope, inverse_variance)[0][:, None] - x
        flank = 1 / np.maximum(gap.real**2 + gap.imag**2, UNIT_ROUNDING**2) ** 2
        np.multiply(trust, flank[:, :, None], out=weight)
        weight *= flank[:, None, :]
    return delta, weight


def _slopes(
    x: FloatArray, delta: ComplexArray, weight: FloatArray
) -> tuple[ComplexArray, ComplexArray, FloatArray]:
    """Return slope, level at x = 0 and one over the slope's variance, each (n_fits, n_lines)."""
    powers = np.stack([np.ones_like(x), x, x**2], axis=2)
    total, mean, square = np.moveaxis(weight @ powers, 2, 0)
    level, tilt = np.moveaxis((weight * delta) @ powers[:, :, :2], 2, 0)
    total = np.where(total > 0, total, 1.0)
    inverse_variance = np.maximum(square - mean**2 / total, 0.0)
    slope = (tilt - level * mean / total) / np.where(inverse_variance > 0, inverse_variance, np.inf)
    return slope, (level - slope * mean) / total, inverse_variance


def _mode(
    x: FloatArray, slope: ComplexArray, inverse_variance: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return eigenvalue and modal constant from the straight line through the slopes."""
    u, v, _ = weighted_line(x, slope, inverse_variance)
    u = np.where(u == 0, UNIT_ROUNDING, u)
    return -v / u, 1 / u


EXTRACTION_METHODS.register("dobson")(
    SingleModeMethod(fit=dobson, plot=dobson_plot, options=DistantLinesOptions)
)
