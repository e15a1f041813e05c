"""Tests whether a remaining gap is random error alone."""

from collections.abc import Mapping

import numpy as np
from scipy.special import chdtri

from modallab.core.arrays import BoolArray
from modallab.diagnosis.fitting.fit import Fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.noise_level_errors import without_noise_level_errors
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import Residual, gap_errors
from modallab.diagnosis.searching.settings import ACCEPTANCE
from modallab.rig.simulated_variance import is_intermittent
from modallab.rig.spectrum_settings import SIMULATED_VARIANCE


def is_noise_only(
    predictor: Predictor, candidate: Fit, *, max_lag: int | None = ACCEPTANCE.correlated_lines
) -> bool:
    """Return whether every part of the gap is 1 within its random error, fitted and held out alike.

    Parameters
    ----------
    max_lag
        As `unexplained_parts`.
    """
    return not unexplained_parts(predictor, candidate, max_lag=max_lag)


def unexplained_parts(predictor: Predictor, candidate: Fit, *, max_lag: int | None) -> set[str]:
    """Return the parts of the gap that are not 1 within their random error, on fitted or held-out data.

    Noise levels may be in error by `ACCEPTANCE.noise_level_error`, where that explains most of a gap. Errors
    of nuisance parameters enlarge the gap of held-out data by a known mean. Effects in bursts state
    the random errors themselves: where the residuals are far smaller, these are not the errors of the data.

    Parameters
    ----------
    max_lag
        As `correlation_lengths`. Leakage correlates all lines, but so does a missing effect, above all an
        unknown noise level: a search takes lines more than a few apart for independent and continues where
        a gap is not small. None asks for a large gap: a verdict has to be sure.
    """
    fitted, held_out = _parts_with_excess(predictor, candidate, max_lag)
    return fitted | held_out | parts_with_wide_errors(predictor, candidate, max_lag=max_lag)


def has_no_lack_of_fit(predictor: Predictor, reference: Fit, candidate: Fit) -> bool:
    """Return whether fitted data show no lack of fit, and held-out data hardly any.

    A further effect has nothing to explain then, though a verdict may still call the held-out gap too large:
    the errors of a model that is a little wrong everywhere differ from place to place.

    Parameters
    ----------
    reference
        Fit without the effects of the candidate.
    """
    lag, mask = ACCEPTANCE.correlated_lines, predictor.observed.held_out_mask
    fitted, held_out = _parts_with_excess(predictor, candidate, lag)
    if fitted or parts_with_wide_errors(predictor, candidate, max_lag=lag):
        return False
    return not held_out or excess_ratio(reference, candidate, mask) < ACCEPTANCE.held_out_excess_ratio


def _parts_with_excess(
    predictor: Predictor, candidate: Fit, max_lag: int | None
) -> tuple[set[str], set[str]]:
    """Return the parts whose gap is larger than by chance, on fitted and on held-out data."""
    observed, residual = predictor.observed, _beside_noise_levels(predictor, candidate)
    fitted = _parts_above_noise(observed, residual, observed.fitted, {}, max_lag)
    held_out = _parts_above_noise(observed, residual, observed.held_out_mask, {}, max_lag)
    if not fitted and held_out and len(predictor.nuisances):
        variance = candidate.prediction_variance
        held_out = _parts_above_noise(observed, residual, observed.held_out_mask, variance, max_lag)
    return fitted, held_out


def _parts_above_noise(
    observed: Observed,
    residual: Residual,
    mask: BoolArray,
    prediction_variance: Mapping[str, float],
    max_lag: int | None,
) -> set[str]:
    """Return the parts of the gap that are larger than by chance, and by the error of predictions.

    Parameters
    ----------
    prediction_variance
        Variance of residuals by errors of fitted parameters, over that of noise, by part.
    """
    errors = gap_errors(observed, residual, mask, max_lag=max_lag)
    limits = {
        part: largest_gap_by_chance(float(np.hypot(error, observed.scale_error)))
        for part, error in errors.items()
    }
    gaps = residual.gaps(mask)
    return {
        part for part, gap in gaps.items() if gap > limits[part] * (1 + prediction_variance.get(part, 0.0))
    }


def _beside_noise_levels(predictor: Predictor, candidate: Fit) -> Residual:
    """Return the residual without errors of noise levels, unless these explain little of its excess."""
    observed, found = predictor.observed, candidate.residual
    corrected = without_noise_level_errors(observed, found, ACCEPTANCE.noise_level_error)
    if found.response is None:
        return found
    gap, rest = (each.gaps(observed.fitted)["response"] for each in (found, corrected))
    return corrected if gap - rest > (gap - 1) / 2 else found


def excess_ratio(before: Fit, after: Fit, mask: BoolArray) -> float:
    """Return the excess of the gap over 1 with further effects, over that without them.

    Parameters
    ----------
    mask
        (n_freq, n_out) data of the gap.
    """
    excess_before, excess = (found.residual.gap(mask) - 1 for found in (before, after))
    return excess / excess_before if excess_before > 0 else np.inf


def parts_with_wide_errors(predictor: Predictor, candidate: Fit, *, max_lag: int | None = None) -> set[str]:
    """Return the fitted parts whose residuals are far smaller than the errors that effects in bursts state.

    Such errors forgive any residual. They are known from a few simulated tests, to a factor.

    Parameters
    ----------
    max_lag
        As `unexplained_parts`.
    """
    if not any(is_intermittent(candidate.effects, test.setup) for test in predictor.tests):
        return set()
    mask = predictor.observed.fitted
    gaps, errors = (
        candidate.residual.gaps(mask),
        gap_errors(predictor.observed, candidate.residual, mask, max_lag=max_lag),
    )
    least = 1 / SIMULATED_VARIANCE.significance_ratio
    return {part for part, gap in gaps.items() if gap < least * smallest_gap_by_chance(errors[part])}


def largest_gap_by_chance(error: float) -> float:
    """Return the largest gap that is compatible with noise, by the standard error of a gap.

    A mean of squares has a chi-square distribution of 2 / error^2 degrees of freedom: with few of them, as
    under leakage, its upper tail is longer than that of a normal distribution.
    """
    freedom = 2 / error**2
    return float(chdtri(freedom, ACCEPTANCE.gap_probability) / freedom)


def smallest_gap_by_chance(error: float) -> float:
    """Return the smallest gap that is compatible with noise, as `largest_gap_by_chance`."""
    freedom = 2 / error**2
    return float(chdtri(freedom, 1 - ACCEPTANCE.gap_probability) / freedom)
