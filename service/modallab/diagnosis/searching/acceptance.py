"""Whether anything is missing still, and whether an effect that was added explains it."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.stats import chi2

from modallab.core.arrays import BoolArray
from modallab.core.place import Channels
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import (
    Residual,
    correlation_lengths,
    gap_error,
    gap_errors,
)
from modallab.rig.effect import Effect

BEYOND_DOUBT = 50.0  # difference in BIC that needs no witness, where there can be none
CONVINCING = 10.0  # difference in BIC that counts as very strong (Kass and Raftery 1995)
ALIKE = 9.0  # difference in chi-square within which two explanations cannot be told apart
LINES_APART = 4  # lines of a channel that are held out: every so many
ROUNDING = 0.1  # difference in BIC of two descriptions of one and the same physics
CLEAR = 2.0  # standard errors that a parameter keeps from `absent`
UNTOLD = 0.25  # of its bounds' distance: a standard error of a number that nothing tells
NEAR_LINES = 8  # lines apart, over which windows and sharp resonances spread a random number
TOLD = 2.0  # standard errors of a gap on what was held out that an effect has to close to be told by it
CHANCE = 3e-5  # probability below which a gap above 1 is not put down to chance: four standard errors


def is_noise_only(predictor: Predictor, left: Residual, *, reach: int | None = NEAR_LINES) -> bool:
    """Return whether every part of the gap is 1 within its scatter, fitted and held out alike.

    Parameters
    ----------
    reach
        As `correlation_lengths`. Leakage correlates all lines, but so does a missing effect, above all an
        unknown noise level: a search takes lines more than a few apart for independent and continues where
        a gap is not small. None asks for a large gap: a verdict has to be sure.
    """
    observed = predictor.observed
    for where in (observed.fitted, observed.held_out_mask):
        errors = gap_errors(observed, left, where, reach=reach)
        if any(gap > largest_gap_by_chance(errors[part]) for part, gap in left.gaps(where).items()):
            return False
    return True


def largest_gap_by_chance(error: float) -> float:
    """Return the largest gap that counts as 1, of a gap's random error if nothing is missing.

    A mean of squares is chi-square with 2 / error^2 degrees of freedom: with few of them, as leakage
    leaves, it reaches further up than a normal number of the same scatter.
    """
    freedom = 2 / error**2
    return float(chi2.isf(CHANCE, freedom) / freedom)


def ranked_by_bic(fits: Sequence[Fit]) -> list[Fit]:
    """Return fits by BIC; of those that differ by rounding alone what belongs to the rig comes first.

    A rig is changed from test to test, a model is not: the likelier place for what was forgotten.
    """
    bic = dict(zip(map(id, fits), _criteria(fits), strict=True))
    order = sorted(fits, key=lambda one: bic[id(one)])
    tied = [one for one in order if bic[id(one)] - bic[id(order[0])] < ROUNDING]
    return sorted(tied, key=lambda one: one.effects[-1].structural) + order[len(tied) :]


def _criteria(fits: Sequence[Fit]) -> list[float]:
    """Return the BIC of each fit; of one with a number more than another it lies no lower than that is told.

    Where power leaks, chi-square takes what goes together over many lines for many witnesses: a loss that
    is two standard errors from none may seem beyond doubt. Standard errors know how lines go together.
    """
    return [one.bic if (least := _least(one, fits)) is None else max(one.bic, least) for one in fits]


def _least(one: Fit, fits: Sequence[Fit]) -> float | None:
    if (simpler := one.effects[-1].reduced_model() if one.effects else None) is None:
        return None
    effect, more = simpler
    plain = next((f for f in fits if f.effects and _same(f.effects[-1], effect)), None)
    if plain is None:
        return None
    errors, values = one.errors[-1], one.effects[-1].parameters
    away = {name: abs(values[name]) / error if error > 0 else np.inf for name, error in errors.items()}
    if any(far < CLEAR for name, far in away.items() if name != more):
        return None  # only a product of its numbers may be told, of which the error of one knows nothing
    told = one.correlation_length * away[more] ** 2
    penalty = (one.bic - one.chi_square) - (plain.bic - plain.chi_square)
    # Far from nothing a standard error tells that there is something, and not how much worse nothing is.
    return float(plain.bic + penalty - told) if told < penalty + CONVINCING else None


def _same(one: Effect, other: Effect) -> bool:
    return one.kind == other.kind and one.at == other.at


def is_significant(predictor: Predictor, before: Fit, after: Fit) -> bool:
    """Return whether an added effect is convincing: by BIC, on what was held out, and by its size."""
    observed = predictor.observed
    likelier = (before.bic - after.bic) / variance_inflation(predictor, after)
    if likelier < CONVINCING:
        return False
    effect = after.effects[-1]
    # Of distortion in bursts the size may be known to a factor only: likelihood alone tells that it is there.
    if not effect.intermittent and not is_nonzero(effect, after.errors[-1]):
        return False
    where = observed.held_out_mask
    alone = _known_to_no_other(observed, effect)
    if alone is None and observed.held_out.any() and not _tells(observed, before, after, where):
        alone = np.ones(len(observed.outputs), bool)
    if alone is not None:
        # No other FRF can bear it out: it has to predict lines of its own that it was not fitted to.
        predictor = predictor.without_lines(LINES_APART).with_nuisances_at(after.nuisance_position)
        where = observed.usable & predictor.observed.held_out_lines[:, None] & alone
        after = fit(predictor, after.effects)
        if likelier > BEYOND_DOUBT and not _tells(observed, before, after, where):
            return True  # as hum that is in one line or two
    held_before, held_after = (f.residual.gap(where) for f in (before, after))
    return held_after < held_before - gap_error(observed, after.residual, where)


def is_nonzero(effect: Effect, errors: Mapping[str, float]) -> bool:
    """Return whether the amount of an effect is told from none by its standard error.

    Where another of its own numbers is not told at all, as an angle by motions along one axis alone, the
    amount is no better told, though both together may be beyond doubt: that is left to the likelihood.
    """
    specs = effect.specs().items()
    if any(s.absent is None and errors[name] > UNTOLD * (s.upper - s.lower) for name, s in specs):
        return True
    amounts = (
        (effect.parameters[name] - s.absent, errors[name]) for name, s in specs if s.absent is not None
    )
    return all(abs(away) >= CLEAR * error for away, error in amounts)


def _known_to_no_other(observed: Observed, effect: Effect) -> BoolArray | None:
    """Return the channels (n_out,) an effect acts on, if it leaves all that are held out as they were."""
    if not isinstance(effect.at, Channels):
        return None
    alone = np.array([effect.acts_on(dof) for dof in observed.outputs])
    held = observed.held_out
    return alone if held.any() and not (alone & held).any() else None


def _tells(observed: Observed, before: Fit, after: Fit, where: BoolArray) -> bool:
    """Return whether what was held out tells if an effect is there: it would show in it."""
    change = before.residual.vector(where) - after.residual.vector(where)
    return float(change @ change) > TOLD * gap_error(observed, after.residual, where) * len(change)


def variance_inflation(predictor: Predictor, best: Fit) -> float:
    """Return by how much chi-square overstates a difference: correlated lines, or an incomplete model."""
    observed = predictor.observed
    lines = max(correlation_lengths(observed, best.residual).values())
    return lines * max(1.0, best.chi_square / best.n_data)


def model_probabilities(predictor: Predictor, fits: Sequence[Fit]) -> list[float]:
    """Return the share of belief of each fit among all, by BIC."""
    scale = variance_inflation(predictor, fits[0])
    bic = np.array(_criteria(fits))
    weight = np.exp(-0.5 * (bic - bic.min()) / scale)
    return [float(w) for w in weight / weight.sum()]
