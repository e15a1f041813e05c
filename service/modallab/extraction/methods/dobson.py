"""Dobson's method: lines through the slopes of a difference quotient."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.lines import Lines, conclude, leave_residual, scale, weighted_line
from modallab.extraction.method import EXTRACTION_METHODS, ModeFits

ROUNDS = 3  # the weights settle to three digits in two


@EXTRACTION_METHODS.register("dobson")
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
    dx = lines.x[:, :, None] - lines.x[:, None, :]
    dz = lines.z[:, :, None] - lines.z[:, None, :]
    usable = (dx != 0) & (dz != 0) & (lines.weight[:, :, None] > 0) & (lines.weight[:, None, :] > 0)
    delta = np.where(usable, dx, 0) / np.where(usable, dz, 1)
    noise = 1 / np.where(lines.weight > 0, lines.weight, 1.0)
    # an error n of a line moves Delta by Delta^2 n / dx
    trust = np.where(usable, dx**2 / (noise[:, :, None] + noise[:, None, :]), 0.0)
    # the first round has only the noisy quotients to judge by; the later ones their fitted values
    size = np.where(usable, np.abs(delta), 1.0)
    for _ in range(ROUNDS):
        eigenvalue, constant = _two_lines(lines, delta, trust / size**4)
        gap = np.abs(eigenvalue[:, None] - lines.x)
        size = gap[:, :, None] * gap[:, None, :] / np.abs(constant)[:, None, None]
    return conclude(lines, eigenvalue, constant, leave_residual(lines, eigenvalue, constant))


def _two_lines(lines: Lines, delta: ComplexArray, weight: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Return eigenvalue and modal constant from the slopes, and the line on which these lie."""
    slope, _ = weighted_line(lines.x[:, None, :], delta, weight)
    total = weight.sum(axis=2, keepdims=True)
    x = lines.x[:, None, :]
    mean = (weight * x).sum(axis=2, keepdims=True) / total
    sure = (weight * (x - mean) ** 2).sum(axis=2)
    u, v = weighted_line(lines.x, slope, sure)
    return -v / u, 1 / u
