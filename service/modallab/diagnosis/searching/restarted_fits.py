"""Fits restarted from other tolerances than those of a round."""

from collections.abc import Sequence
from contextlib import suppress

from modallab.core.errors import InvalidInputError
from modallab.diagnosis.fitting.coarse_fit import coarse_fit
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.round_settings import ROUND
from modallab.diagnosis.searching.scan_settings import LOSS
from modallab.rig.effect import Effect


def fitted_from_explanation(
    predictor: Predictor, accepted: Sequence[Effect], fits: Sequence[Fit], explanation: Fit
) -> list[Fit]:
    """Return the fits of a round, those of rivals begun anew at an explanation's tolerances if better.

    Their own fits may have ended elsewhere: a mass at the drive point is the force transducer's as well, but
    one fit had come to it, one had not. Nonlinear forces stay as they are: their fits cost most.

    Parameters
    ----------
    accepted
        Effects that all fits have.
    fits
        With one effect more, the last one.
    explanation
        One of them.
    """
    if not len(predictor.nuisances):
        return list(fits)
    predictor = predictor.with_nuisances_at(explanation.nuisance_position)
    coarse, inflation = predictor.coarse_prediction(accepted), LOSS.noise_inflations[1]
    _, least = coarse_fit(coarse, accepted, explanation.effects[-1], inflation)

    def renewed(found: Fit) -> Fit:
        effect = found.effects[-1]
        equal = found.chi_square <= (1 + ROUND.same_cost) * explanation.chi_square
        if equal or effect.on_motion() is not None:
            return found
        with suppress(InvalidInputError):
            start, cost = coarse_fit(coarse, accepted, effect, inflation)
            if cost <= ROUND.hopeless_cost * least:
                other = fit(predictor, (*accepted, start))
                return min(found, other, key=lambda each: each.chi_square)
        return found

    return [renewed(found) for found in fits]


def with_best_from_base(predictor: Predictor, base: Fit, fits: Sequence[Fit]) -> list[Fit]:
    """Return the fits of a round, the best one restarted from the tolerances of the base, if better.

    While none comes near the data: far from them the cost has many minima, and which start leads to the
    lowest is not known.

    Parameters
    ----------
    base
        The fit of the accepted effects.
    fits
        Fits of the accepted effects with one suspect added.
    """
    if not fits or not len(predictor.nuisances) or predictor.budget.exhausted:
        return list(fits)
    if base.is_near_data or any(found.is_near_data for found in fits):
        return list(fits)
    best = min(fits, key=Fit.bic_between_kinds)
    predictor = predictor.with_nuisances_at(base.nuisance_position)
    with suppress(InvalidInputError):
        other = fit(predictor, best.effects, approach=True)
        if other.chi_square < best.chi_square:
            return [other if found is best else found for found in fits]
    return list(fits)
