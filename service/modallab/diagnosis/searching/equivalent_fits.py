"""Fits of a round that a measurement cannot tell from the one that was accepted."""

from dataclasses import replace

from modallab.diagnosis.fitting.fit import Fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import incomplete_variance_inflation
from modallab.diagnosis.searching.gap_tests import excess_ratio, unexplained_parts
from modallab.diagnosis.searching.search_path import AcceptedEffect, SearchPath, kind_and_place
from modallab.diagnosis.searching.settings import ACCEPTANCE, SEARCH


def without_undetermined_effects(predictor: Predictor, path: SearchPath) -> SearchPath:
    """Return a path without its last effects where others do as well and none of them leaves noise alone.

    What remains beside the first effects is then more than any effect explains, and which one comes
    nearest is chance: a model that is wrong everywhere by a little leaves as much. An effect that closes most
    of what remained is present: it stays, and so do its equivalents. One that has a single equivalent, or
    stays, gives way to an equivalent with fewer parameters: an oscillator tuned far above the band to a mass.
    """
    while len(path.steps) > 1 and unexplained_parts(predictor, path.fit, max_lag=None):
        *others, last = path.steps
        chosen = named_fit(last)
        equivalents = equivalent_fits(predictor, last, chosen)
        if not equivalents:
            break
        simpler, closes_most = (
            equivalents[0],
            excess_ratio(last.previous_fit, last.fit, predictor.observed.fitted) < SEARCH.undetermined_ratio,
        )
        if (closes_most or len(equivalents) == 1) and simpler.n_parameters < chosen.n_parameters:
            name = kind_and_place(simpler.effects[-1])
            others.append(replace(last, kind_and_place=name, fit=simpler))
        elif closes_most:
            break
        path = SearchPath(path.start, tuple(others))
    return path


def named_fit(step: AcceptedEffect) -> Fit:
    """Return the fit of a step's round with the effect that was accepted."""
    last_effects = ((candidate, candidate.effects[-1]) for candidate in step.round_fits)
    return next(
        candidate
        for candidate, effect in last_effects
        if (effect.kind, str(effect.at)) == step.kind_and_place
    )


def equivalent_fits(predictor: Predictor, step: AcceptedEffect, chosen: Fit) -> list[Fit]:
    """Return the fits of a step's round that agree with the chosen one in chi-square, within its error.

    Among effects of the structure, and likewise among effects of the rig, only those with the fewest
    parameters count: an oscillator tuned far above the band has the same effect as a mass, which has fewer.
    An effect of the structure does not exclude an effect of the rig: the stinger's bending stiffness may have
    one parameter more than the rotational spring to which it is equivalent.
    """
    limit = ACCEPTANCE.equivalence_chi_square * incomplete_variance_inflation(predictor, step.round_fits[0])
    pool = [
        candidate for candidate in step.round_fits if abs(candidate.chi_square - chosen.chi_square) < limit
    ]
    least_parameters = {
        structural: min(c.n_parameters for c in pool if c.effects[-1].structural == structural)
        for structural in {c.effects[-1].structural for c in pool}
    }
    return [
        c for c in pool if c is not chosen and c.n_parameters == least_parameters[c.effects[-1].structural]
    ]
