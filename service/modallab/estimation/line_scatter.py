"""Random error of FRFs from the scatter of neighbouring lines about a smooth local model."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.numerics import COHERENCE_ROUNDING, SAFE_DIVISOR
from modallab.estimation.error_correlation import (
    ErrorCorrelation,
    likeliest_correlation,
    log_likelihoods,
    refined_correlation,
)
from modallab.estimation.settings import LINE_SCATTER
from modallab.estimation.windows import WINDOWS, Window


@dataclass(frozen=True)
class Estimate:
    """A number estimated from scatter, with its random error."""

    value: float
    """The estimate."""
    standard_error: float
    """Its standard error, in the same unit."""


@dataclass(frozen=True)
class AveragesEstimate(Estimate):
    """Effective number of averages, with the window that the lines show."""

    correlation: ErrorCorrelation
    """Correlation of the errors of neighbouring lines under which the residuals are most likely."""


@dataclass(frozen=True, eq=False)
class _Stretches:
    """Groups of neighbouring lines, each of one FRF."""

    frf: ComplexArray
    """(n, n_lines) lines over the rms of the stretch."""
    deviation: FloatArray
    """(n, n_lines) standard deviation over the same rms, smooth within the stretch."""
    usable: BoolArray
    """(n_stretches, n_frf) which of all groups these n are."""


def estimated_averages(
    values: ComplexArray, coherence: FloatArray, window: Window | None
) -> AveragesEstimate | None:
    """Return the effective number of averages of a coherence; None if it is 1, without random error.

    For given forces the variance of H1 over n averages is the noise of the response over n G_ff, and the
    incoherent power is on average (n - 1)/n of that noise (Goodman 1963). The variance of neighbouring lines
    is therefore |H|^2 (1 - g2)/(g2 (n - 1)), with the estimated coherence g2, from which n follows.

    Parameters
    ----------
    values
        (n_freq, n_frf) FRFs.
    coherence
        (n_freq, n_frf), 0 to 1.
    window
        Window of the records, which correlates neighbouring lines; None: unknown.

    Raises
    ------
    InvalidInputError
        If the lines are too few for an estimate.
    """
    stretches = _stretches_by_coherence(values, coherence)
    if stretches is None:
        return None
    if stretches.usable.any(axis=1).sum() < LINE_SCATTER.min_stretches:
        raise InvalidInputError(
            "too few lines to estimate the averages, which coherence alone does not tell",
            field="averages",
            allowed=bounds(1),
        )
    correlation, beside = _correlations(stretches, window)
    scale, other = (_typical(_scatter(stretches, each)) for each in (correlation, beside))
    n = 1 / max(scale.value, SAFE_DIVISOR)
    error = np.hypot(scale.standard_error, other.value - scale.value) / max(scale.value, SAFE_DIVISOR)
    return AveragesEstimate(1 + n, n * float(error), correlation)


def estimated_error(values: ComplexArray, window: Window | None) -> tuple[Estimate, ...] | None:
    """Return the random error of each FRF over its median magnitude, (n_frf,); None if unknown.

    It is the standard deviation of the real part, which is the relative error of the magnitude, at the median
    line.
    """
    stretches = _stretches(values, np.ones(values.shape))
    sizes = np.median(np.abs(values), axis=0)
    if len(stretches.usable) < LINE_SCATTER.min_stretches or not (sizes > 0).all():
        return None
    ratios = _scatter(stretches, _correlations(stretches, window)[0])
    errors = []
    for ratio, size in zip(ratios.T, sizes, strict=True):
        scale = _typical(ratio[:, None])
        deviation = np.sqrt(scale.value / 2) / size
        errors.append(
            Estimate(deviation, deviation * scale.standard_error / (2 * scale.value + SAFE_DIVISOR))
        )
    return tuple(errors)


def likeliest_window(values: ComplexArray, coherence: FloatArray, averages: float, declared: str) -> str:
    """Return the name of the window under which the random errors of neighbouring lines are likeliest.

    Another sum of cosines than the declared one must be likelier by more than the standard error of the
    logarithm of the likelihood ratio (Vuong 1989, Econometrica 57, 307-333), and likelier in most stretches
    of lines (Clarke 2007, Political Analysis 15, 347-363): one in which the smooth local model does not hold
    can outweigh all others. Only those count whose scatter is the one that coherence and averages tell: where
    it is larger that model does not hold, where it is smaller the lines have no random errors.

    Parameters
    ----------
    values, coherence
        As in `estimated_averages`.
    averages
        Effective number of averages.
    declared
        Name of the window that the log book declares.
    """
    windows = {name: window for name, window in WINDOWS.items() if not window.transient}
    stretches = _stretches_by_coherence(values, coherence)
    if declared not in windows or stretches is None or averages <= 1:
        return declared
    fits = _residuals(stretches, np.eye(LINE_SCATTER.stretch_lines))
    n_spare = fits[1].shape[1]
    limit = LINE_SCATTER.plausible_scatter * np.sqrt(n_spare)
    plausible = np.zeros(len(fits[1]), bool)
    likelihoods = {}
    for name, window in windows.items():
        correlations = [ErrorCorrelation(window, random_force=random) for random in (False, True)]
        each = [log_likelihoods(*fits, correlation) for correlation in correlations]
        likelihoods[name], squares = max(each, key=lambda pair: float(pair[0].sum()))
        plausible |= np.abs(squares * (averages - 1) - n_spare) < limit
    if plausible.sum() < LINE_SCATTER.min_stretches:
        return declared
    gains = {name: (each - likelihoods[declared])[plausible] for name, each in likelihoods.items()}
    best_name = max(gains, key=lambda name: float(gains[name].sum()))
    gain = gains[best_name]
    error = gain.std() * np.sqrt(len(gain))
    significant = gain.sum() > LINE_SCATTER.window_significance * error and np.median(gain) > 0
    return best_name if significant else declared


def _stretches_by_coherence(values: ComplexArray, coherence: FloatArray) -> _Stretches | None:
    """Return groups of neighbouring lines with variances that coherence tells, of one average.

    None if the coherence is 1, without random error.
    """
    known = (coherence > LINE_SCATTER.min_coherence) & (np.abs(values) > 0)
    relative = np.where(known, (1 - coherence) / np.maximum(coherence, LINE_SCATTER.min_coherence), 0.0)
    if not (relative[known] > COHERENCE_ROUNDING).any():
        return None
    variance = np.abs(values) ** 2 * np.maximum(relative, COHERENCE_ROUNDING)
    return _stretches(values, np.where(known, variance, np.nan))


def _stretches(values: ComplexArray, variance: FloatArray) -> _Stretches:
    """Return groups of neighbouring lines of all FRFs.

    The variance (n_freq, n_frf) of a line has an error of its own, so that a stretch has one level of it: of
    the variance itself or of the relative one, whichever is more even.
    """
    width = LINE_SCATTER.stretch_lines
    n, n_frf = len(values) // width, values.shape[1]
    step = max(1, n * n_frf // LINE_SCATTER.max_stretches)
    index = np.arange(0, n, step)[:, None] * width + np.arange(width)
    h, v = (part[index].transpose(0, 2, 1) for part in (values, variance))
    usable = np.asarray(np.isfinite(v).all(axis=2) & (v > 0).all(axis=2))
    h, v = h[usable], v[usable]
    power = np.abs(h) ** 2
    relative = v / np.maximum(power, SAFE_DIVISOR)
    proportional = np.log(relative + SAFE_DIVISOR).var(axis=1) < np.log(v).var(axis=1)
    level = np.where(
        proportional[:, None],
        power * relative.mean(axis=1, keepdims=True),
        v.mean(axis=1, keepdims=True),
    )
    size = np.sqrt(power.mean(axis=1, keepdims=True)) + SAFE_DIVISOR
    return _Stretches(h / size, np.sqrt(level) / size, usable)


def _correlations(stretches: _Stretches, window: Window | None) -> tuple[ErrorCorrelation, ErrorCorrelation]:
    """Return the correlation of the errors of neighbouring lines, and the one a standard error beside it.

    Fits to lines taken as independent start it; those to lines made independent are less biased.
    """
    n = LINE_SCATTER.stretch_lines
    start = likeliest_correlation(*_residuals(stretches, np.eye(n)), window)
    if not start.exponential:
        return start, start
    return refined_correlation(*_residuals(stretches, start.whitening(n)), start)


def _scatter(stretches: _Stretches, correlation: ErrorCorrelation) -> FloatArray:
    """Return mean squares of residuals over their expectation, (n_stretches, n_frf); nan if unknown."""
    _, residual = _residuals(stretches, correlation.whitening(LINE_SCATTER.stretch_lines))
    ratios = np.full(stretches.usable.shape, np.nan)
    ratios[stretches.usable] = (np.abs(residual) ** 2).mean(axis=1)
    return ratios


def _residuals(
    stretches: _Stretches, whitening: FloatArray | ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return an orthonormal basis of the residuals of smooth fits, (n, n_lines, n_spare), with coefficients.

    In every interval of lines a quotient of quadratic polynomials is fitted, which represents two resonances.
    The linearised least-squares problem is weighted by the denominator of the previous step (Sanathanan and
    Koerner 1963).

    Parameters
    ----------
    whitening
        (n_lines, n_lines) matrix that makes the errors of lines over their standard deviation independent.
    """
    h, order = stretches.frf, LINE_SCATTER.order
    powers = np.linspace(-1.0, 1.0, h.shape[1]) ** np.arange(order + 1)[:, None]
    numerator = np.broadcast_to(powers, (len(h), order + 1, h.shape[1]))
    columns = np.concatenate([numerator, -h[:, None] * powers[1:]], axis=1).swapaxes(1, 2)
    denominator = np.ones(h.shape, complex)
    for _ in range(LINE_SCATTER.reweightings):
        weight = 1 / (stretches.deviation * denominator)
        weighted = whitening @ (columns * weight[..., None])
        target = (h * weight) @ whitening.T
        q, r = np.linalg.qr(weighted)
        projected = q.conj().swapaxes(1, 2) @ target[..., None]
        regular = r + SAFE_DIVISOR * np.eye(r.shape[-1])
        solution = np.linalg.solve(regular, projected)[..., 0]
        denominator = 1 + solution[:, order + 1 :] @ powers[1:]
        denominator = np.where(np.abs(denominator) > LINE_SCATTER.least_denominator, denominator, 1.0)
    complete = np.linalg.qr(weighted, mode="complete")[0]
    spare = complete[..., columns.shape[-1] :]
    return whitening.conj().T @ spare, (spare.conj().swapaxes(1, 2) @ target[..., None])[..., 0]


def _typical(ratios: FloatArray) -> Estimate:
    """Return the variance that stretches show, by their median, with the error that groups of them show.

    The median, as in some stretches the model does not hold; groups of whole stretches, as the noise of a
    force is in all FRFs.
    """
    degrees_of_freedom = 2 * (LINE_SCATTER.stretch_lines - 2 * LINE_SCATTER.order - 1)
    # Wilson and Hilferty (1931): the median of a chi-square variable over its mean.
    median_of_chi_square = (1 - 2 / (9 * degrees_of_freedom)) ** 3
    scale = float(np.nanmedian(ratios)) / median_of_chi_square
    n_groups = min(LINE_SCATTER.groups, len(ratios) // 2)
    groups = [ratios[i::n_groups] for i in range(n_groups)]
    medians = np.array([np.nanmedian(group) for group in groups if np.isfinite(group).any()])
    return Estimate(scale, float(medians.std(ddof=1) / np.sqrt(len(medians)) / median_of_chi_square))
