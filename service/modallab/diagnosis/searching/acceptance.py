"""Acceptance: whether an effect is missing still, and whether an added effect is significant."""

from collections.abc import Mapping, Sequence
from itertools import takewhile

import numpy as np

from modallab.core.arrays import BoolArray
from modallab.core.dof import Dof
from modallab.core.parameters import ParameterSpec
from modallab.core.place import Channels
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.fitting.settings import FIT
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.noise_level_errors import without_noise_level_errors
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import Residual, correlation_lengths, gap_error
from modallab.diagnosis.searching.gap_tests import is_noise_only, parts_with_wide_errors
from modallab.diagnosis.searching.settings import ACCEPTANCE
from modallab.rig.effect import Effect, Stage


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
