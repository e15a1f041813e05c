"""Line-fit: the inverse of the response against frequency squared."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.options import DistantLinesOptions
from modallab.extraction.single_mode.lines import (
    ROUNDING,
    Lines,
    conclude,
    mode_beside_constant,
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


@in_blocks
def line_fit(freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> ModeFits:
    """Inverse response as a straight line in omega^2, after the residual is taken off.

    `1/(alpha - R) = (lambda_r - omega^2)/A` [5.23]: slope and intercept, both complex, give a mode
    with a complex constant. A constant R would bend the line, so it is found first from
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
    return conclude(lines, -intercept / slope, -1 / slope, residual)


def line_fit_plot(
    freq: FloatArray, frf: ComplexArray, weight: FloatArray
) -> dict[str, FloatArray | ComplexArray]:
    """The inverse of the response without its residual, and the straight line through it, both complex."""
    lines, x, points = one_row(freq, frf, weight)
    slope, intercept, residual = (values[0] for values in _inverse_line(lines))
    mode = lines.z[0] - residual
    shown = np.abs(mode) >= ROUNDING
    return {
        "x": x[shown],
        "inverse": 1 / (mode[shown] * lines.size),
        "line": (slope * lines.x[0, shown] + intercept) / lines.size,
        "residual": np.atleast_1d(residual) * lines.size,
        "points": points[shown],
    }


def _inverse_line(lines: Lines) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return slope and intercept of 1/(z - R) against x, and R, each (n_fits,)."""
    residual = mode_beside_constant(lines)[2]
    mode = lines.z - residual[:, None]
    blank = np.abs(mode) < ROUNDING
    inverse = np.asarray(1 / np.where(blank, np.inf, mode), complex)
    size = np.abs(mode)
    for _ in range(2):  # once with the noisy sizes, once with the fitted ones
        # an error n of a line moves its inverse by n/alpha^2
        slope, intercept, _ = weighted_line(lines.x, inverse, np.where(blank, 0, lines.weight) * size**4)
        slope = np.where(slope == 0, ROUNDING, slope)
        size = 1 / np.abs(slope[:, None] * lines.x + intercept[:, None])
    return slope, intercept, residual


EXTRACTION_METHODS.register("line_fit")(
    SingleModeMethod(fit=line_fit, plot=line_fit_plot, options=DistantLinesOptions)
)
