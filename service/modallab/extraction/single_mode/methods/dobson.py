"""Dobson's method: lines through the slopes of a difference quotient."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.options import DistantLinesOptions
from modallab.extraction.single_mode.lines import (
    Lines,
    conclude,
    leave_residual,
    one_row,
    scale,
    weighted_line,
)
from modallab.extraction.single_mode.method import (
    EXTRACTION_METHODS,
    ModeFits,
    SingleModeMethod,
    in_blocks,
)

TINY = 1e-15  # of values of order one
ROUNDS = 3  # the weights settle to three digits in two


@in_blocks
def dobson(freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> ModeFits:
    """Difference quotients turned into straight lines; a constant residual drops out.

    With a reference line W, `Delta = (omega^2 - W^2) / (alpha(omega) - alpha(W))` is a line in
    omega^2 whose slope is `u W^2 + v`, `u = 1/A`, `v = -lambda_r/A`. Both complex at once, so that no
    branch is needed for real or imaginary constants.

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
    slope, _, sure = _slopes(lines.x, delta, final)
    eigenvalue, constant = _mode(lines.x, slope, sure)
    return conclude(lines, eigenvalue, constant, leave_residual(lines, eigenvalue, constant))


def dobson_plot(
    freq: FloatArray, frf: ComplexArray, weight: FloatArray
) -> dict[str, FloatArray | ComplexArray]:
    """The difference quotients of every reference line and their lines; the slopes of these and theirs.

    `delta` (n_lines, n_lines - 1), by reference: no line has a quotient with itself; `slopes` (n_lines,).
    """
    lines, x, points = one_row(freq, frf, weight)
    delta, final = _quotients(lines)
    slope, level, sure = _slopes(lines.x, delta, final)
    u, v, _ = weighted_line(lines.x, slope, sure)
    drawn = slope[0, :, None] * lines.x[0] + level[0, :, None]
    apart = ~np.eye(len(x), dtype=bool)
    shape = (len(x), len(x) - 1)
    scale_of_delta = lines.half / lines.size
    return {
        "x": x,
        "points": points,
        "x_delta": np.broadcast_to(x, apart.shape)[apart].reshape(shape),
        "delta": delta[0][apart].reshape(shape) * scale_of_delta,
        "delta_lines": drawn[apart].reshape(shape) * scale_of_delta,
        "slopes": slope[0] / lines.size,
        "slope_line": (u * lines.x[0] + v) / lines.size,
    }


def _quotients(lines: Lines) -> tuple[ComplexArray, FloatArray]:
    """Return Delta and its weights, (n_fits, n_lines, n_lines), references along the second axis."""
    x, used = lines.x, lines.weight > 0
    noise = np.where(used, 1 / np.where(used, lines.weight, 1.0), np.inf)
    sure = 1 / (noise[:, :, None] + noise[:, None, :])
    dx = x[:, :, None] - x[:, None, :]
    dz = lines.z[:, :, None] - lines.z[:, None, :]
    square, power = dx**2, dz.real**2 + dz.imag**2
    inverse = 1 / np.where(power > 0, power, np.inf)
    delta = np.asarray(dz.conj() * (dx * inverse), complex)
    # an error n of a line moves Delta by Delta^2 n / dx; the first round has only the noisy quotients to
    # judge by, the later ones their fitted values
    trust = np.where(power > 0, sure * square, 0.0)
    weight = power * power
    weight *= sure / np.where(square > 0, square, np.inf)
    for _ in range(ROUNDS - 1):
        slope, _, steep = _slopes(x, delta, weight)
        gap = _mode(x, slope, steep)[0][:, None] - x
        flank = 1 / np.maximum(gap.real**2 + gap.imag**2, TINY**2) ** 2
        np.multiply(trust, flank[:, :, None], out=weight)
        weight *= flank[:, None, :]
    return delta, weight


def _slopes(
    x: FloatArray, delta: ComplexArray, weight: FloatArray
) -> tuple[ComplexArray, ComplexArray, FloatArray]:
    """Return slope, level at x = 0 and certainty of every reference's line, each (n_fits, n_lines)."""
    powers = np.stack([np.ones_like(x), x, x**2], axis=2)
    total, mean, square = np.moveaxis(weight @ powers, 2, 0)
    level, tilt = np.moveaxis((weight * delta) @ powers[:, :, :2], 2, 0)
    total = np.where(total > 0, total, 1.0)
    sure = np.maximum(square - mean**2 / total, 0.0)
    slope = (tilt - level * mean / total) / np.where(sure > 0, sure, np.inf)
    return slope, (level - slope * mean) / total, sure


def _mode(x: FloatArray, slope: ComplexArray, sure: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Return eigenvalue and modal constant from the line on which the slopes lie."""
    u, v, _ = weighted_line(x, slope, sure)
    u = np.where(u == 0, TINY, u)
    return -v / u, 1 / u


EXTRACTION_METHODS.register("dobson")(
    SingleModeMethod(fit=dobson, plot=dobson_plot, options=DistantLinesOptions)
)
