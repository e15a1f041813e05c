"""The arithmetic all single-mode methods share: scaled lines in, mode with standard errors out."""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.extraction.options import MIN_LINES
from modallab.extraction.single_mode.method import ModeFits, Outcome

Number = TypeVar("Number", np.float64, np.complex128)

# A response that changes by less than this part of its size over a band holds rounding only.
FLAT = 1e-12
TINY = 1e-100
ROUNDING = 1e-15  # of values of order one
ROUNDS = 4  # of the weights of what is linear in its unknowns; each wins two digits or more


@dataclass(frozen=True, eq=False)
class Lines:
    """Windows on scales of their own: x = omega^2 from -1 to 1, |z| up to 1.

    Rows that cannot be fitted carry a harmless stand-in, so that nothing downstream divides by zero.
    """

    x: FloatArray  # (n_fits, n_lines)
    z: ComplexArray  # (n_fits, n_lines)
    weight: FloatArray  # (n_fits, n_lines), one over the variance of z
    centre: FloatArray  # (n_fits,) (rad/s)^2
    half: FloatArray  # (n_fits,) (rad/s)^2
    size: FloatArray  # (n_fits,) unit of the response
    outcome: IntArray  # (n_fits,) Outcome before any fit
    lower: FloatArray  # (n_fits,) first and last line in use, on the scale of x
    upper: FloatArray


def scale(freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> Lines:
    """Return the windows scaled to order one; lines that are not finite lose their weight."""
    usable = np.isfinite(frf) & np.isfinite(weight) & (weight > 0)
    few = usable.sum(axis=1) < MIN_LINES
    frf, weight = np.where(usable, frf, 0), np.where(usable, weight, 0.0)
    x = (2 * np.pi * freq) ** 2
    low = np.where(few, 0.0, np.where(usable, x, np.inf).min(axis=1, initial=np.inf))
    high = np.where(few, 0.0, np.where(usable, x, -np.inf).max(axis=1, initial=-np.inf))
    size = np.abs(frf).max(axis=1, initial=0.0)
    middle = np.where(few, 0, frf.sum(axis=1) / np.maximum(usable.sum(axis=1), 1))
    change = np.abs(np.where(usable, frf - middle[:, None], 0)).max(axis=1, initial=0.0)
    flat = ~few & (change <= FLAT * size)
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


def one_row(
    freq: FloatArray, frf: ComplexArray, weight: FloatArray
) -> tuple[Lines, FloatArray, ComplexArray]:
    """Return the lines in use of one stretch, scaled, a batch of one; and their omega^2 and response.

    Parameters
    ----------
    freq, frf, weight
        (n_lines,) as `FitPlot`.
    """
    used = np.isfinite(frf) & np.isfinite(weight) & (weight > 0)
    lines = scale(freq[None, used], frf[None, used], weight[None, used])
    return lines, (2 * np.pi * freq[used]) ** 2, frf[used]


def weighted_line(
    x: FloatArray, y: ComplexArray, weight: FloatArray
) -> tuple[ComplexArray, ComplexArray, FloatArray]:
    """Return slope, intercept and the slope's certainty (one over its variance) along the last axis.

    Where the weights leave no line to draw, all three are zero.
    """
    total = weight.sum(axis=-1)
    mean = (weight * x).sum(axis=-1) / np.where(total > 0, total, 1)
    lever = weight * (x - mean[..., None])
    sure = (lever * x).sum(axis=-1)
    drawn = sure > 0
    slope = np.where(drawn, (lever * y).sum(axis=-1) / np.where(drawn, sure, 1), 0)
    intercept = (weight * y).sum(axis=-1) / np.where(total > 0, total, 1) - slope * mean
    return slope, intercept, np.where(drawn, sure, 0.0)


def mode_beside_constant(lines: Lines) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return eigenvalue, modal constant and residual, each (n_fits,), by a fit linear in its unknowns.

    `z x = lambda z + c + R x` with `c = -(A + R lambda)`. An error n of a line leaves `(x - lambda) n` of
    it, so that the weights need the eigenvalue: they are renewed.
    """
    weight = lines.weight * np.abs(lines.z) ** 2  # 1/|lambda - x|^2 is not known yet; this is its shape
    for _ in range(ROUNDS):
        eigenvalue, constant, residual = _linear_step(lines, weight)
        gap = np.maximum(np.abs(eigenvalue[:, None] - lines.x), ROUNDING)
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
    determinant = np.where(determinant == 0, TINY, determinant)
    eigenvalue = (dot(x, x) * dot(z, y) - zx * dot(x, y)) / determinant
    residual = (dot(z, z) * dot(x, y) - zx.conj() * dot(z, y)) / determinant
    level = middles[2] - eigenvalue * middles[0] - residual * middles[1]
    return eigenvalue, np.asarray(-(level + residual * eigenvalue)), residual


def leave_residual(lines: Lines, eigenvalue: ComplexArray, constant: ComplexArray) -> ComplexArray:
    """Return the constant that is left beside a mode, (n_fits,), on the scale of z."""
    left = lines.z - constant[:, None] / (eigenvalue[:, None] - lines.x)
    residual: ComplexArray = (lines.weight * left).sum(axis=1) / lines.weight.sum(axis=1)
    return residual


def conclude(
    lines: Lines,
    eigenvalue: ComplexArray,
    constant: ComplexArray,
    residual: ComplexArray,
    quality: dict[str, FloatArray] | None = None,
) -> ModeFits:
    """Return the fits in physical units, with what the random error of the lines does to them.

    `eigenvalue`, `constant` and `residual` (n_fits,) are on the scale of `lines`. The standard errors
    are those of the weighted least-squares fit linearised at the result.
    """
    physical = lines.centre + lines.half * eigenvalue
    inside = (eigenvalue.real > lines.lower) & (eigenvalue.real < lines.upper)
    # what is wider than half the window cannot be told from the background
    inside &= (eigenvalue.imag > 0) & (eigenvalue.imag < 1)
    finite = np.isfinite(eigenvalue) & np.isfinite(constant) & np.isfinite(residual) & (constant != 0)
    outcome = np.where(
        (lines.outcome == Outcome.FOUND) & ~(inside & finite), Outcome.NO_RESONANCE, lines.outcome
    )
    found = outcome == Outcome.FOUND
    pole = np.where(found, eigenvalue, 0.1j)
    variances, misfit = linearised(lines, pole, np.where(found, constant, 1), np.where(found, residual, 0))
    stiffness = np.where(found, physical.real, 1.0)
    loss_factor = np.where(found, physical.imag, 0.0) / stiffness
    frequency = np.sqrt(stiffness) / (2 * np.pi)
    part = np.sqrt(variances / 2)  # a complex error shares its square between its two parts
    eigenvalue_error = lines.half * part[:, 0]
    return ModeFits(
        frequency=_only(found, frequency),
        loss_factor=loss_factor,
        modal_constant=_only(found, constant * lines.size * lines.half),
        residual=_only(found, residual * lines.size),
        frequency_error=_only(found, eigenvalue_error / (8 * np.pi**2 * frequency)),
        loss_factor_error=_only(found, eigenvalue_error / stiffness * np.hypot(1, loss_factor)),
        modal_constant_error=_only(found, part[:, 1] * lines.size * lines.half),
        residual_error=_only(found, part[:, 2] * lines.size),
        misfit=_only(found, misfit),
        outcome=outcome.astype(np.int64),
        quality={name: _only(found, values) for name, values in (quality or {}).items()},
    )


def linearised(
    lines: Lines, eigenvalue: ComplexArray, constant: ComplexArray, residual: ComplexArray
) -> tuple[FloatArray, FloatArray]:
    """Return E|error|^2 of eigenvalue, constant and residual, (n_fits, 3), and the misfit (n_fits,)."""
    gap = eigenvalue[:, None] - lines.x
    slopes = [-constant[:, None] / gap**2, 1 / gap, np.ones_like(gap)]
    size = [(lines.weight * (s.real**2 + s.imag**2)).sum(axis=1) for s in slopes]
    # Correlations of the three columns; the inverse of their 3 x 3 matrix by cofactors
    pairs = [
        (lines.weight * slopes[i].conj() * slopes[j]).sum(axis=1) / np.sqrt(size[i] * size[j])
        for i, j in ((1, 2), (0, 2), (0, 1))
    ]
    shared = [np.abs(pair) ** 2 for pair in pairs]
    determinant = 1 - sum(shared) + 2 * (pairs[2] * pairs[0] * pairs[1].conj()).real
    # what rounding hides gets a large but finite error
    determinant = np.maximum(determinant, 1e-14)
    variances = np.stack(
        # correlation only ever widens an error
        [np.maximum((1 - s) / determinant, 1) / d for s, d in zip(shared, size, strict=True)],
        axis=1,
    )
    left = lines.z - constant[:, None] / gap - residual[:, None]
    n_lines = (lines.weight > 0).sum(axis=1)
    spare = np.maximum(n_lines - 3, 1)
    return variances, (lines.weight * np.abs(left) ** 2).sum(axis=1) / spare


def _only(found: BoolArray, values: NDArray[Number]) -> NDArray[Number]:
    return np.where(found, values, np.zeros((), values.dtype))
