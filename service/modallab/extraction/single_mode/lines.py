"""Common arithmetic of single-mode methods: scaled lines, linear fits, standard errors."""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.numerics import PRODUCT_ROUNDING, SAFE_SQUARED_DIVISOR, SUM_ROUNDING, UNIT_ROUNDING
from modallab.extraction.options import MIN_LINES
from modallab.extraction.single_mode.method import ModeFits, Outcome
from modallab.extraction.single_mode.settings import LINEAR_FIT

Number = TypeVar("Number", np.float64, np.complex128)


@dataclass(frozen=True, eq=False)
class Lines:
    """Windows on normalised scales: x = omega^2 from -1 to 1, |z| up to 1.

    Rows that cannot be fitted contain substitute values, so that later divisions are finite.
    """

    x: FloatArray
    """(n_fits, n_lines) normalised omega^2."""
    z: ComplexArray
    """(n_fits, n_lines) normalised response."""
    weight: FloatArray
    """(n_fits, n_lines) one over the variance of z."""
    centre: FloatArray
    """(n_fits,) (rad/s)^2, centre of the window."""
    half: FloatArray
    """(n_fits,) (rad/s)^2, half width of the window."""
    size: FloatArray
    """(n_fits,) largest modulus, unit of the response."""
    outcome: IntArray
    """(n_fits,) `Outcome` before the fit."""
    lower: FloatArray
    """(n_fits,) first line in use, on the scale of x."""
    upper: FloatArray
    """(n_fits,) last line in use, on the scale of x."""


def scale(freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> Lines:
    """Return the windows on normalised scales; lines that are not finite get no weight."""
    usable = np.isfinite(frf) & np.isfinite(weight) & (weight > 0)
    few = usable.sum(axis=1) < MIN_LINES
    frf, weight = np.where(usable, frf, 0), np.where(usable, weight, 0.0)
    x = (2 * np.pi * freq) ** 2
    low = np.where(few, 0.0, np.where(usable, x, np.inf).min(axis=1, initial=np.inf))
    high = np.where(few, 0.0, np.where(usable, x, -np.inf).max(axis=1, initial=-np.inf))
    size = np.abs(frf).max(axis=1, initial=0.0)
    middle = np.where(few, 0, frf.sum(axis=1) / np.maximum(usable.sum(axis=1), 1))
    change = np.abs(np.where(usable, frf - middle[:, None], 0)).max(axis=1, initial=0.0)
    flat = ~few & (change <= PRODUCT_ROUNDING * size)
    bad = few | flat
    centre, half = np.where(bad, 0.0, low + high) / 2, np.where(bad, 1.0, (high - low) / 2)
    size = np.where(bad, 1.0, size)
    stand_in = np.linspace(-1, 1, freq.shape[1])
    x = np.where(bad[:, None], stand_in, (x - centre[:, None]) / half[:, None])
    z = np.where(bad[:, None], 1 / (0.1j - stand_in), frf / size[:, None])
    return Lines(
        x=np.clip(x, -2, 2),
        z=z,
        weight=np.where(bad[:, None], 1.0, weight * size[:, None] ** 2),
        centre=centre,
        half=half,
        size=size,
        outcome=np.select([few, flat], [Outcome.TOO_FEW_LINES, Outcome.NO_SHAPE], Outcome.FOUND),
        lower=np.where(bad, -1.0, (low - centre) / half),
        upper=np.where(bad, 1.0, (high - centre) / half),
    )


def single_window(
    freq: FloatArray, frf: ComplexArray, weight: FloatArray
) -> tuple[Lines, FloatArray, ComplexArray]:
    """Return the used lines of one window as a batch of one, their omega^2, and their response.

    Parameters
    ----------
    freq, frf, weight
        (n_lines,) as in an `ExtractionMethod`.
    """
    used = np.isfinite(frf) & np.isfinite(weight) & (weight > 0)
    lines = scale(freq[None, used], frf[None, used], weight[None, used])
    return lines, (2 * np.pi * freq[used]) ** 2, frf[used]


def weighted_line(
    x: FloatArray, y: ComplexArray, weight: FloatArray
) -> tuple[ComplexArray, ComplexArray, FloatArray]:
    """Return slope, intercept and one over the variance of the slope, of a weighted line along the last axis.

    All three are zero where the weights do not determine a line.
    """
    total = weight.sum(axis=-1)
    mean = (weight * x).sum(axis=-1) / np.where(total > 0, total, 1)
    lever = weight * (x - mean[..., None])
    inverse_variance = (lever * x).sum(axis=-1)
    determined = inverse_variance > 0
    slope = np.where(determined, (lever * y).sum(axis=-1) / np.where(determined, inverse_variance, 1), 0)
    intercept = (weight * y).sum(axis=-1) / np.where(total > 0, total, 1) - slope * mean
    return slope, intercept, np.where(determined, inverse_variance, 0.0)


def fit_mode_and_constant(lines: Lines) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return eigenvalue, modal constant and residual, each (n_fits,), by a fit linear in its unknowns.

    `z x = lambda z + c + R x` with `c = -(A + R lambda)` (Levy's equation). An error n of a line contributes
    `(x - lambda) n`, so that the weights depend on the eigenvalue and are renewed (Sanathanan and Koerner).
    """
    weight = lines.weight * np.abs(lines.z) ** 2  # proportional to 1/|lambda - x|^2, which is not known yet
    for _ in range(LINEAR_FIT.weight_iterations):
        eigenvalue, constant, residual = _linear_step(lines, weight)
        gap = np.maximum(np.abs(eigenvalue[:, None] - lines.x), UNIT_ROUNDING)
        weight = lines.weight / gap**2
    return eigenvalue, constant, residual


def _linear_step(lines: Lines, weight: FloatArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return lambda, A and R of one weighted least-squares fit."""
    total = weight.sum(axis=1)

    def mean(values: ComplexArray) -> ComplexArray:
        middle: ComplexArray = (weight * values).sum(axis=1) / total
        return middle

    columns = lines.z, lines.x.astype(complex), np.asarray(lines.z * lines.x)
    middles = [mean(column) for column in columns]
    z, x, y = (column - middle[:, None] for column, middle in zip(columns, middles, strict=True))

    def dot(a: ComplexArray, b: ComplexArray) -> ComplexArray:
        product: ComplexArray = (weight * a.conj() * b).sum(axis=1)
        return product

    zx = dot(z, x)
    determinant = dot(z, z) * dot(x, x) - np.abs(zx) ** 2
    determinant = np.where(determinant == 0, SAFE_SQUARED_DIVISOR, determinant)
    eigenvalue = (dot(x, x) * dot(z, y) - zx * dot(x, y)) / determinant
    residual = (dot(z, z) * dot(x, y) - zx.conj() * dot(z, y)) / determinant
    level = middles[2] - eigenvalue * middles[0] - residual * middles[1]
    return eigenvalue, np.asarray(-(level + residual * eigenvalue)), residual


def mean_residual(lines: Lines, eigenvalue: ComplexArray, constant: ComplexArray) -> ComplexArray:
    """Return the weighted mean of the response without its mode, (n_fits,), on the scale of z."""
    remainder = lines.z - constant[:, None] / (eigenvalue[:, None] - lines.x)
    residual: ComplexArray = (lines.weight * remainder).sum(axis=1) / lines.weight.sum(axis=1)
    return residual


def physical_fits(
    lines: Lines,
    eigenvalue: ComplexArray,
    constant: ComplexArray,
    residual: ComplexArray,
    quality: dict[str, FloatArray] | None = None,
) -> ModeFits:
    """Return the fits in physical units, with standard errors from the random error of the lines.

    `eigenvalue`, `constant` and `residual` (n_fits,) are on the scale of `lines`. Standard errors are those
    of the weighted least-squares fit linearised at the result.
    """
    physical = lines.centre + lines.half * eigenvalue
    inside = (eigenvalue.real > lines.lower) & (eigenvalue.real < lines.upper)
    # a mode wider than half the window cannot be separated from the residual
    inside &= (eigenvalue.imag > 0) & (eigenvalue.imag < 1)
    finite = np.isfinite(eigenvalue) & np.isfinite(constant) & np.isfinite(residual) & (constant != 0)
    outcome = np.where(
        (lines.outcome == Outcome.FOUND) & ~(inside & finite), Outcome.NO_RESONANCE, lines.outcome
    )
    has_mode = outcome == Outcome.FOUND
    pole = np.where(has_mode, eigenvalue, 0.1j)
    variances, misfit = error_variances(
        lines, pole, np.where(has_mode, constant, 1), np.where(has_mode, residual, 0)
    )
    stiffness = np.where(has_mode, physical.real, 1.0)
    loss_factor = np.where(has_mode, physical.imag, 0.0) / stiffness
    frequency = np.sqrt(stiffness) / (2 * np.pi)
    part_error = np.sqrt(variances / 2)  # half of the squared complex error belongs to either part
    eigenvalue_error = lines.half * part_error[:, 0]
    return ModeFits(
        frequency=_where_found(has_mode, frequency),
        loss_factor=loss_factor,
        modal_constant=_where_found(has_mode, constant * lines.size * lines.half),
        residual=_where_found(has_mode, residual * lines.size),
        frequency_error=_where_found(has_mode, eigenvalue_error / (8 * np.pi**2 * frequency)),
        loss_factor_error=_where_found(has_mode, eigenvalue_error / stiffness * np.hypot(1, loss_factor)),
        modal_constant_error=_where_found(has_mode, part_error[:, 1] * lines.size * lines.half),
        residual_error=_where_found(has_mode, part_error[:, 2] * lines.size),
        misfit=_where_found(has_mode, misfit),
        outcome=outcome.astype(np.int64),
        quality={name: _where_found(has_mode, values) for name, values in (quality or {}).items()},
    )


def error_variances(
    lines: Lines, eigenvalue: ComplexArray, constant: ComplexArray, residual: ComplexArray
) -> tuple[FloatArray, FloatArray]:
    """Return E|error|^2 of eigenvalue, constant and residual, (n_fits, 3), and the misfit (n_fits,)."""
    gap = eigenvalue[:, None] - lines.x
    slopes = [-constant[:, None] / gap**2, 1 / gap, np.ones_like(gap)]
    size = [(lines.weight * (s.real**2 + s.imag**2)).sum(axis=1) for s in slopes]
    # correlations of the three columns; the inverse of their 3 x 3 matrix by cofactors
    correlations = [
        (lines.weight * slopes[i].conj() * slopes[j]).sum(axis=1) / np.sqrt(size[i] * size[j])
        for i, j in ((1, 2), (0, 2), (0, 1))
    ]
    squared_correlations = [np.abs(pair) ** 2 for pair in correlations]
    determinant = (
        1 - sum(squared_correlations) + 2 * (correlations[2] * correlations[0] * correlations[1].conj()).real
    )
    # columns that are dependent within rounding get a large but finite error
    determinant = np.maximum(determinant, SUM_ROUNDING)
    variances = np.stack(
        # correlation only ever widens an error
        [np.maximum((1 - s) / determinant, 1) / d for s, d in zip(squared_correlations, size, strict=True)],
        axis=1,
    )
    remainder = lines.z - constant[:, None] / gap - residual[:, None]
    n_lines = (lines.weight > 0).sum(axis=1)
    spare = np.maximum(n_lines - 3, 1)  # three complex unknowns
    return variances, (lines.weight * np.abs(remainder) ** 2).sum(axis=1) / spare


def _where_found(has_mode: BoolArray, values: NDArray[Number]) -> NDArray[Number]:
    return np.where(has_mode, values, np.zeros((), values.dtype))
