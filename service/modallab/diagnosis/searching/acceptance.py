"""Acceptance: whether an effect is missing still, and whether an added effect is significant."""

from collections.abc import Mapping, Sequence
from itertools import takewhile

import numpy as np
from scipy.special import chdtri

from modallab.core.arrays import BoolArray
from modallab.core.dof import Dof
from modallab.core.parameters import ParameterSpec
from modallab.core.place import Channels
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.fitting.settings import FIT
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.noise_level_errors import without_noise_level_errors
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import Residual, correlation_lengths, gap_error, gap_errors
from modallab.diagnosis.searching.settings import ACCEPTANCE
from modallab.rig.effect import Effect, Stage
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
    observed, found = predictor.observed, _beside_noise_levels(predictor, candidate)

    def excess(mask: BoolArray, allowed: Mapping[str, float]) -> set[str]:
        errors = gap_errors(observed, found, mask, max_lag=max_lag)
        limits = {
            part: largest_gap_by_chance(float(np.hypot(error, observed.scale_error)))
            for part, error in errors.items()
        }
        gaps = found.gaps(mask)
        return {part for part, gap in gaps.items() if gap > limits[part] * (1 + allowed.get(part, 0.0))}

    fitted, held_out = excess(observed.fitted, {}), excess(observed.held_out_mask, {})
    if not fitted and held_out and len(predictor.nuisances):
        held_out = excess(observed.held_out_mask, candidate.prediction_variance)
    return fitted | held_out | parts_with_wide_errors(predictor, candidate, max_lag=max_lag)


def _beside_noise_levels(predictor: Predictor, candidate: Fit) -> Residual:
    """Return the residual without errors of noise levels, unless these explain little of its excess."""
    observed, found = predictor.observed, candidate.residual
    corrected = without_noise_level_errors(observed, found, ACCEPTANCE.noise_level_error)
    if found.response is None:
        return found
    gap, rest = (each.gaps(observed.fitted)["response"] for each in (found, corrected))
    return corrected if gap - rest > (gap - 1) / 2 else found


def excess_ratio(predictor: Predictor, before: Fit, after: Fit) -> float:
    """Return the excess of the fitted gap over 1 with further effects, over that without them."""
    mask = predictor.observed.fitted
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


def ranked_by_bic(fits: Sequence[Fit]) -> list[Fit]:
    """Return fits by BIC; of those that describe the same physics effects of the rig come first.

    A rig changes from test to test, a model does not: an omission there is the likelier one. Where the best
    fit leaves more than random error, its mean square is the variance of the residuals (overdispersion):
    Burnham and Anderson, Model Selection and Multimodel Inference, 2nd ed. (2002), section 2.5.
    """
    overdispersion = max(1.0, min((f.chi_square / f.n_data for f in fits), default=1.0))
    bic = dict(zip(map(id, fits), _criteria(fits, overdispersion), strict=True))
    order = sorted(fits, key=lambda candidate: bic[id(candidate)])

    def is_equal(candidate: Fit) -> bool:
        difference = overdispersion * (bic[id(candidate)] - bic[id(order[0])])
        return difference < ACCEPTANCE.same_physics_bic

    equal = list(takewhile(is_equal, order))
    return sorted(equal, key=lambda candidate: candidate.effects[-1].structural) + order[len(equal) :]


def _criteria(fits: Sequence[Fit], overdispersion: float = 1.0) -> list[float]:
    """Return the BIC of each fit, bounded from below for an effect that extends another fitted one.

    Under leakage chi-square counts correlated lines as independent: a loss of two standard errors may seem
    decisive. The standard error of the additional parameter includes the correlation of lines, so the gain
    over the reduced model is at most the square of its significance.
    """
    bic = {id(candidate): candidate.bic_between_kinds(overdispersion) for candidate in fits}
    bounds = [_lower_bound(candidate, fits, bic) for candidate in fits]
    return [
        bic[id(candidate)] if bound is None else max(bic[id(candidate)], bound)
        for candidate, bound in zip(fits, bounds, strict=True)
    ]


def _lower_bound(candidate: Fit, fits: Sequence[Fit], bic: Mapping[int, float]) -> float | None:
    """Return the lower bound of a BIC, see `_criteria`; None if no reduced model was fitted."""
    reduced = candidate.effects[-1].reduced_model() if candidate.effects else None
    if reduced is None:
        return None
    effect, extra_parameters = reduced
    plain = next((f for f in fits if f.effects and _same_place(f.effects[-1], effect)), None)
    if plain is None:
        return None
    errors, values = candidate.errors[-1], candidate.effects[-1].parameters
    significance = {
        name: abs(values[name]) / error if error > 0 else np.inf for name, error in errors.items()
    }
    other_significance = (value for name, value in significance.items() if name not in extra_parameters)
    if any(value < ACCEPTANCE.min_significance for value in other_significance):
        return None  # the data may determine only a product of its parameters, not the error of one
    gain = candidate.correlation_length * sum(significance[name] ** 2 for name in extra_parameters)
    penalty = candidate.penalty_between_kinds - plain.penalty_between_kinds
    # Far from zero a standard error shows that the parameter is nonzero, not how much worse zero is.
    return float(bic[id(plain)] + penalty - gain) if gain < penalty + ACCEPTANCE.very_strong_bic else None


def _same_place(first: Effect, second: Effect) -> bool:
    return first.kind == second.kind and first.at == second.at


def is_significant(predictor: Predictor, previous: Fit, candidate: Fit) -> bool:
    """Return whether an added effect is significant: by BIC, on held-out data, and by its amount.

    Never with random errors that are not those of the data, nor by what errors of the noise levels explain.
    """
    observed, effect = predictor.observed, candidate.effects[-1]
    gain = previous.bic - candidate.bic - _due_to_noise_levels(observed, previous.residual)
    gain /= variance_inflation(predictor, candidate)
    if gain < ACCEPTANCE.very_strong_bic or parts_with_wide_errors(predictor, candidate):
        return False
    # The size of distortion in bursts may be known to a factor only: its BIC decides alone.
    by_bic_alone = effect.intermittent or _releases_active_limit(predictor, previous, candidate)
    if not by_bic_alone and not is_nonzero(effect, candidate.errors[-1]):
        return False
    mask = observed.held_out_mask
    channels = _untested_channels(observed, effect)
    if channels is None and observed.held_out.any() and not _is_testable(observed, previous, candidate, mask):
        channels = np.ones(len(observed.outputs), bool)
    if channels is not None:
        # No held-out FRF tests the effect: it has to predict held-out lines of its own channels.
        predictor = predictor.without_lines(ACCEPTANCE.validation_lines)
        predictor = predictor.with_nuisances_at(candidate.nuisance_position)
        mask = observed.usable & predictor.observed.held_out_lines[:, None] & channels
        candidate = fit(predictor, candidate.effects)
        if gain > ACCEPTANCE.decisive_bic and not _is_testable(observed, previous, candidate, mask):
            return True  # as hum, which is in one line or two
    previous_gap, gap = (f.residual.gap(mask) for f in (previous, candidate))
    return gap < previous_gap - gap_error(observed, candidate.residual, mask)


def _due_to_noise_levels(observed: Observed, found: Residual) -> float:
    """Return the part of chi-square that errors of the declared noise levels account for."""
    corrected = without_noise_level_errors(observed, found, ACCEPTANCE.noise_level_error)
    before, after = (each.vector(observed.fitted) for each in (found, corrected))
    return float(before @ before - after @ after)


def is_nonzero(effect: Effect, errors: Mapping[str, float]) -> bool:
    """Return whether the amount of an effect differs from its neutral value by its standard error.

    Where another parameter of the effect is undetermined, as an angle by motions along one axis alone, so
    is the amount, though both together may be decisive: then BIC decides alone.
    """
    specs = [(name, spec) for name, spec, _ in effect.fitted_specs()]
    if any(_is_undetermined(spec, errors[name]) for name, spec in specs):
        return True
    amounts = (
        (effect.parameters[name] - s.absent, errors[name]) for name, s in specs if s.absent is not None
    )
    return all(abs(amount) >= ACCEPTANCE.min_significance * error for amount, error in amounts)


def _releases_active_limit(predictor: Predictor, previous: Fit, candidate: Fit) -> bool:
    """Return whether the added effect moves a nuisance parameter off its limit, an active constraint.

    Effect and tolerance then share a deviation: the standard error of either holds that of the other.
    """
    reached = (1 - ACCEPTANCE.limit_accuracy) * predictor.nuisances.limits
    before, after = (np.abs(each.nuisance_position) >= reached for each in (previous, candidate))
    return bool((before & ~after).any())


def is_undetermined(candidate: Fit) -> bool:
    """Return whether the data leave a parameter of the last effect open, other than its amount."""
    specs, errors = candidate.effects[-1].fitted_specs(), candidate.errors[-1]
    return any(_is_undetermined(spec, errors[name]) for name, spec, _ in specs)


def _is_undetermined(spec: ParameterSpec, error: float) -> bool:
    return spec.absent is None and error > ACCEPTANCE.undetermined * (spec.upper - spec.lower)


def _untested_channels(observed: Observed, effect: Effect) -> BoolArray | None:
    """Return the channels (n_out,) that an effect acts on; None unless it leaves all held-out ones alone."""
    of_force = effect.stage is Stage.CHANNEL and isinstance(effect.at, Dof)
    if not of_force and not isinstance(effect.at, Channels):
        return None
    acted_on = [channel.drive if of_force else channel.response for channel in observed.channels]
    channels = np.array([effect.acts_on(dof) for dof in acted_on])
    held_out = observed.held_out
    return channels if held_out.any() and not (channels & held_out).any() else None


def _is_testable(observed: Observed, previous: Fit, candidate: Fit, mask: BoolArray) -> bool:
    """Return whether held-out data test an effect: it changes their residuals beyond the random error."""
    change = previous.residual.vector(mask) - candidate.residual.vector(mask)
    error = gap_error(observed, candidate.residual, mask)
    return float(change @ change) > ACCEPTANCE.held_out_significance * error * len(change)


def variance_inflation(predictor: Predictor, best: Fit) -> float:
    """Return the variance inflation of chi-square: by correlated lines and by an incomplete model."""
    observed = predictor.observed
    lines = max(correlation_lengths(observed, best.residual).values())
    return lines * max(1.0, best.chi_square / best.n_data)


def incomplete_variance_inflation(predictor: Predictor, best: Fit) -> float:
    """Return the variance inflation between rivals, also where none of them leaves noise alone.

    What is missing still is a few numbers a resonance: it weighs as much as a few independent data, and
    which rival comes nearer to it by less than that is chance.
    """
    inflation = variance_inflation(predictor, best)
    if is_noise_only(predictor, best, max_lag=None):
        return inflation
    excess = max(0.0, best.chi_square - best.n_data)
    return max(inflation, best.correlation_length * excess / FIT.missing_effect_data)


def model_probabilities(predictor: Predictor, fits: Sequence[Fit]) -> list[float]:
    """Return the probability of each fit among all, by BIC."""
    scale = incomplete_variance_inflation(predictor, fits[0])
    bic = np.array(_criteria(fits))
    weight = np.exp(-0.5 * (bic - bic.min()) / scale)
    return [float(w) for w in weight / weight.sum()]
