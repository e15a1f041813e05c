"""Fits of rivals from the tolerances of an explanation."""

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
