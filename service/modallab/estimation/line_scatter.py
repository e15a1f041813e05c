"""Random error of FRFs from the scatter of neighbouring lines about a smooth local model."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.numerics import COHERENCE_ROUNDING, SAFE_DIVISOR
from modallab.estimation.settings import LINE_SCATTER, SPECTRUM
from modallab.estimation.windows import Window


@dataclass(frozen=True)
class Estimate:
    """A number estimated from scatter, with its random error."""

    value: float
    """The estimate."""
    standard_error: float
    """Its standard error, in the same unit."""


def estimated_averages(values: ComplexArray, coherence: FloatArray, window: Window) -> Estimate | None:
    """Return the effective number of averages of a coherence; None if it is 1: there is no random error.

    H1 of n averages scatters about its expectation by |H|^2 (1 - g2)/(g2 (n - 2)), g2 the coherence (Goodman
    1963): the scatter of neighbouring lines tells n.

    Parameters
    ----------
    values
        (n_freq, n_frf) FRFs.
    coherence
        (n_freq, n_frf), 0 to 1.
    window
        Window of the records, which correlates neighbouring lines.

    Raises
    ------
    InvalidInputError
        If there are too few lines to tell it.
    """
    known = (coherence > LINE_SCATTER.min_coherence) & (np.abs(values) > 0)
    relative = np.where(known, (1 - coherence) / np.maximum(coherence, LINE_SCATTER.min_coherence), 0.0)
    if not (relative[known] > COHERENCE_ROUNDING).any():
        return None
    variance = np.abs(values) ** 2 * np.maximum(relative, COHERENCE_ROUNDING)
    ratios = _scatter(values, np.where(known, variance, np.nan), window)
    scale = _typical(ratios)
    if scale is None:
        raise InvalidInputError(
            "too few lines to estimate the averages, which coherence alone does not tell",
            field="averages",
            allowed=bounds(1),
        )
    n = 1 / max(scale.value, SAFE_DIVISOR)
    return Estimate(2 + n, n * scale.standard_error / max(scale.value, SAFE_DIVISOR))


def estimated_error(values: ComplexArray, window: Window) -> tuple[Estimate, ...] | None:
    """Return the random error of each FRF, (n_frf,) over the median of its magnitude; None if not told.

    The standard deviation of the real part, which is the relative error of the magnitude, at the median line.
    """
    variance = np.ones(values.shape)
    ratios = _scatter(values, variance, window)
    errors = []
    for ratio, size in zip(ratios.T, np.median(np.abs(values), axis=0), strict=True):
        scale = _typical(ratio[:, None])
        if scale is None or not size > 0:
            return None
        deviation = np.sqrt(scale.value / 2) / size
        errors.append(
            Estimate(deviation, deviation * scale.standard_error / (2 * scale.value + SAFE_DIVISOR))
        )
    return tuple(errors)


def _scatter(values: ComplexArray, variance: FloatArray, window: Window) -> FloatArray:
    """Return squares of residuals over their expectation, (n_stretches, n_frf); nan if unknown.

    In every stretch a quotient of quadratic polynomials is fitted, which takes up two resonances; linearised
    least squares are weighted anew by the denominator (Sanathanan and Koerner 1963).
    """
    width, order = LINE_SCATTER.stretch_lines, LINE_SCATTER.order
    n = len(values) // width
    if n == 0:
        return np.zeros((0, values.shape[1]))
    stretches = np.arange(n)
    step = max(1, n * values.shape[1] // LINE_SCATTER.max_stretches)
    stretches = stretches[::step]
    index = stretches[:, None] * width + np.arange(width)
    h = values[index].transpose(0, 2, 1)
    sigma = np.sqrt(variance[index].transpose(0, 2, 1))
    usable = np.isfinite(sigma).all(axis=2) & (sigma > 0).all(axis=2)
    sigma = np.where(usable[..., None], sigma, 1.0)
    size = np.sqrt((np.abs(h) ** 2).mean(axis=2, keepdims=True)) + SAFE_DIVISOR
    h, sigma = h / size, sigma / size
    t = np.linspace(-1.0, 1.0, width)
    powers = t ** np.arange(order + 1)[:, None]
    columns = np.concatenate(
        [
            np.broadcast_to(powers, (*h.shape[:2], order + 1, width)),
            -h[:, :, None] * powers[1:],
        ],
        axis=2,
    ).swapaxes(2, 3)
    denominator = np.ones(h.shape, complex)
    for _ in range(LINE_SCATTER.reweightings):
        weight = 1 / (sigma * np.abs(denominator))
        q, r = np.linalg.qr(columns * weight[..., None])
        target = h * weight
        projected = (q.conj().swapaxes(2, 3) @ target[..., None])[..., 0]
        regular = r + SAFE_DIVISOR * np.eye(r.shape[-1])
        solution = np.linalg.solve(regular, projected[..., None])[..., 0]
        denominator = 1 + solution[..., order + 1 :] @ powers[1:]
        denominator = np.where(np.abs(denominator) > LINE_SCATTER.least_denominator, denominator, 1.0)
    residual = target - (q @ projected[..., None])[..., 0]
    correlation = _correlation(window, width)
    taken = np.einsum("wfka,kl,wfla->wf", q.conj(), correlation, q).real
    expected = np.trace(correlation) - taken
    squares = (np.abs(residual) ** 2).sum(axis=2)
    return np.asarray(np.where(usable, squares / expected, np.nan))


def _correlation(window: Window, width: int) -> FloatArray:
    """Return the correlation (width, width) of the random errors of H1 at neighbouring lines.

    A window correlates the lines of force and noise alike; those of their product by the square.
    """
    power = window.samples(SPECTRUM.window_samples) ** 2
    by_lag = np.abs(np.fft.fft(power)[:width] / power.sum()) ** 2
    lag = np.abs(np.arange(width)[:, None] - np.arange(width))
    return np.asarray(by_lag[lag])


def _typical(ratios: FloatArray) -> Estimate | None:
    """Return the variance that stretches show, by their median, with the error that groups of them show.

    The median, as in some stretches the model does not hold; groups of whole stretches, as the noise of a
    force is in all FRFs.
    """
    n = len(ratios)
    if np.isfinite(ratios).any(axis=1).sum() < LINE_SCATTER.min_stretches:
        return None
    freedom = 2 * (LINE_SCATTER.stretch_lines - 2 * LINE_SCATTER.order - 1)
    # Wilson and Hilferty (1931): the median of a chi-square variable over its mean.
    median_of_chi_square = (1 - 2 / (9 * freedom)) ** 3
    scale = float(np.nanmedian(ratios)) / median_of_chi_square
    n_groups = min(LINE_SCATTER.groups, n // 2)
    groups = [ratios[i::n_groups] for i in range(n_groups)]
    medians = np.array([np.nanmedian(group) for group in groups if np.isfinite(group).any()])
    return Estimate(scale, float(medians.std(ddof=1) / np.sqrt(len(medians)) / median_of_chi_square))
