"""Line fit: the inverse of the response against squared frequency."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import UNIT_ROUNDING
from modallab.extraction.options import DistantLinesOptions
from modallab.extraction.single_mode.lines import (
    Lines,
    fit_mode_and_constant,
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


@in_blocks
def line_fit(freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> ModeFits:
    """Inverse response as a straight line in omega^2, after subtraction of the residual.

    `1/(alpha - R) = (lambda_r - omega^2)/A` [5.23]: slope and intercept, both complex, give a mode
    with a complex constant. A constant R would bend the line; it is determined first from
    `alpha omega^2 = lambda_r alpha + R omega^2 - (A + R lambda_r)`, which is linear in its unknowns.

    Parameters
    ----------
    freq, frf, weight
        As `ExtractionMethod`.

    References
    ----------
    Dobson, B. J. (1987), Mechanical Systems and Signal Processing 1, 29-40; 1992 thesis, eq. [5.23].
    """
    lines = scale(freq, frf, weight)
    slope, intercept, residual = _inverse_line(lines)
    return physical_fits(lines, -intercept / slope, -1 / slope, residual)


def line_fit_plot(
    freq: FloatArray, frf: ComplexArray, weight: FloatArray
) -> dict[str, FloatArray | ComplexArray]:
    """Return the inverse of the response without its residual, and its straight line, both complex."""
    lines, x, points = single_window(freq, frf, weight)
    slope, intercept, residual = (values[0] for values in _inverse_line(lines))
    mode = lines.z[0] - residual
    usable = np.abs(mode) >= UNIT_ROUNDING
    return {
        "x": x[usable],
        "inverse": 1 / (mode[usable] * lines.size),
        "line": (slope * lines.x[0, usable] + intercept) / lines.size,
        "residual": np.atleast_1d(residual) * lines.size,
        "points": points[usable],
    }


def _inverse_line(lines: Lines) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return slope and intercept of 1/(z - R) against x, and R, each (n_fits,)."""
    residual = fit_mode_and_constant(lines)[2]
    mode = lines.z - residual[:, None]
    blank = np.abs(mode) < UNIT_ROUNDING
    inverse = np.asarray(1 / np.where(blank, np.inf, mode), complex)
    size = np.abs(mode)
    for _ in range(2):  # weights from the noisy response, then from the fitted one
        # an error n of a line changes its inverse by n/alpha^2
        slope, intercept, _ = weighted_line(lines.x, inverse, np.where(blank, 0, lines.weight) * size**4)
        slope = np.where(slope == 0, UNIT_ROUNDING, slope)
        size = 1 / np.abs(slope[:, None] * lines.x + intercept[:, None])
    return slope, intercept, residual


EXTRACTION_METHODS.register("line_fit")(
    SingleModeMethod(fit=line_fit, plot=line_fit_plot, options=DistantLinesOptions)
)
