"""Line-fit: the inverse of the response against frequency squared."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.lines import Lines, conclude, scale, weighted_line
from modallab.extraction.method import EXTRACTION_METHODS, ModeFits, in_blocks

TINY = 1e-100
ROUNDING = 1e-15  # of values of order one
ROUNDS = 4  # of the residual's weights; each wins two digits or more


@EXTRACTION_METHODS.register("line_fit")
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
    residual = _residual(lines)
    mode = lines.z - residual[:, None]
    blank = np.abs(mode) < ROUNDING
    inverse = np.asarray(1 / np.where(blank, np.inf, mode), complex)
    size = np.abs(mode)
    for _ in range(2):  # once with the noisy sizes, once with the fitted ones
        # an error n of a line moves its inverse by n/alpha^2
        slope, intercept, _ = weighted_line(lines.x, inverse, np.where(blank, 0, lines.weight) * size**4)
        slope = np.where(slope == 0, ROUNDING, slope)
        size = 1 / np.abs(slope[:, None] * lines.x + intercept[:, None])
    return conclude(lines, -intercept / slope, -1 / slope, residual)


def _residual(lines: Lines) -> ComplexArray:
    """Return the constant beside the mode, (n_fits,), by a linear fit whose weights are renewed."""
    weight = lines.weight * np.abs(lines.z) ** 2  # 1/|lambda - x|^2 is not known yet; this is its shape
    for _ in range(ROUNDS):
        eigenvalue, residual = _linear_fit(lines, weight)
        gap = np.maximum(np.abs(eigenvalue[:, None] - lines.x), ROUNDING)
        weight = lines.weight / gap**2
    return residual


def _linear_fit(lines: Lines, weight: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Return lambda and R of z x = lambda z + R x + constant, by weighted least squares."""
    total = weight.sum(axis=1, keepdims=True)

    def centred(values: ComplexArray) -> ComplexArray:
        left: ComplexArray = values - (weight * values).sum(axis=1, keepdims=True) / total
        return left

    z, x, y = centred(lines.z), centred(lines.x.astype(complex)), centred(np.asarray(lines.z * lines.x))

    def dot(a: ComplexArray, b: ComplexArray) -> ComplexArray:
        product: ComplexArray = (weight * a.conj() * b).sum(axis=1)
        return product

    zx = dot(z, x)
    determinant = dot(z, z) * dot(x, x) - np.abs(zx) ** 2
    determinant = np.where(determinant == 0, TINY, determinant)
    eigenvalue = (dot(x, x) * dot(z, y) - zx * dot(x, y)) / determinant
    residual = (dot(z, z) * dot(x, y) - zx.conj() * dot(z, y)) / determinant
    return eigenvalue, residual
