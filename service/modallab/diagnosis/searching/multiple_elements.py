"""Several wrong elements as one explanation: whether it holds, and what else might stand in for each."""

from dataclasses import replace

from modallab.core.progress import Progress, part
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import (
    CONVINCING,
    is_noise_only,
    is_nonzero,
    variance_inflation,
)
from modallab.diagnosis.searching.search_path import AcceptedEffect, SearchPath, kind_and_place
from modallab.diagnosis.searching.search_round import Suspects, fit_candidates
from modallab.diagnosis.searching.wrong_elements import wrong_elements
from modallab.rig.effect import Effect

PAIR = 2  # effects up to which an explanation is as simple as what is looked for first
FEIGNED = 0.02  # change of a factor below which three or more of them may only feign another cause


def multiple_elements(
    predictor: Predictor, best: Fit, suspects: Suspects, *, max_effects: int, progress: Progress
) -> Fit | None:
    """Return the fit of few effects at elements that leave only noise, held out or not; None if none do.

    Parameters
    ----------
    best
        What a single effect explains best: they have to be worth their number beside it.
    """
    found = wrong_elements(predictor.with_nuisances_at(best.starting_position), suspects.effects, progress)
    if not 0 < len(found) <= max_effects or (len(found) > PAIR and min(map(_change, found)) < FEIGNED):
        return None
    fitted = fit(predictor.with_nuisances_at(best.starting_position), found)
    worth = best.bic - fitted.bic > CONVINCING * variance_inflation(predictor, fitted)
    clear = all(map(is_nonzero, fitted.effects, fitted.errors))
    return fitted if worth and clear and is_noise_only(predictor, fitted.residual) else None


def _change(effect: Effect) -> float:
    return abs(next(iter(effect.parameters.values())) - 1)


def verify(
    predictor: Predictor, start: Fit, found: Fit, suspects: Suspects, progress: Progress
) -> SearchPath:
    """Return effects that were found together as a path, each with what might take its place.

    That is looked for with the others in the matrices, where they cost nothing, among what has no more
    numbers: anything else is the worse explanation at best.
    """
    predictor = predictor.with_nuisances_at(found.nuisance_position)
    simple = replace(suspects, effects=[e for e in suspects.effects if len(e.specs()) <= 1])
    names = [kind_and_place(effect) for effect in found.effects]
    steps: list[AcceptedEffect] = []
    for i, effect in enumerate(found.effects):
        round_ = part(progress, i / len(names), (i + 1) / len(names))
        others = tuple(e for j, e in enumerate(found.effects) if j != i)
        beside = predictor.folded_into_matrices(others)
        rivals = fit_candidates(beside, fit(beside, ()), simple, progress=round_)
        own = fit(predictor, (*others, effect))
        tried = (own, *(one for one in rivals if kind_and_place(one.effects[-1]) not in names))
        steps.append(AcceptedEffect(names[i], start, own, tried))
    return SearchPath(start, tuple(steps))
