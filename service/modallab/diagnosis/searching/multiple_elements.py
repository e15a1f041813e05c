"""Several wrong elements as one explanation: acceptance, and the rivals of each."""

from dataclasses import replace

from modallab.core.progress import Progress, part
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import is_nonzero, variance_inflation
from modallab.diagnosis.searching.gap_tests import is_noise_only
from modallab.diagnosis.searching.search_path import AcceptedEffect, SearchPath, kind_and_place
from modallab.diagnosis.searching.search_round import fit_candidates
from modallab.diagnosis.searching.settings import ACCEPTANCE, MULTIPLE_ELEMENTS, SEARCH
from modallab.diagnosis.searching.suspects import Suspects
from modallab.diagnosis.searching.wrong_elements import wrong_elements
from modallab.rig.effect import Effect


def multiple_elements(
    predictor: Predictor, best: Fit, suspects: Suspects, *, max_effects: int, progress: Progress
) -> Fit | None:
    """Return the fit of a few effects at elements that leave only noise, held out or not; None if none do.

    Parameters
    ----------
    best
        The best fit of a single effect, which they have to improve significantly.
    """
    predictor_near = predictor.with_nuisances_at(best.starting_position)
    elements = wrong_elements(predictor_near, suspects.effects, progress)
    if not 0 < len(elements) <= max_effects:
        return None
    if len(elements) > SEARCH.pair and min(map(_change, elements)) < MULTIPLE_ELEMENTS.min_change:
        return None
    candidate = fit(predictor_near, elements)
    gain = best.bic - candidate.bic
    significant = gain > ACCEPTANCE.very_strong_bic * variance_inflation(predictor, candidate)
    nonzero = all(map(is_nonzero, candidate.effects, candidate.errors))
    return candidate if significant and nonzero and is_noise_only(predictor, candidate) else None


def _change(effect: Effect) -> float:
    return abs(next(iter(effect.parameters.values())) - 1)


def verify(
    predictor: Predictor, start: Fit, elements: Fit, suspects: Suspects, progress: Progress
) -> SearchPath:
    """Return effects that were found together as a path, each with its rivals.

    Rivals of one effect are sought with the other effects folded into the matrices, where they cost
    nothing, among suspects with at most one parameter: any other rival is the worse explanation.
    """
    predictor = predictor.with_nuisances_at(elements.nuisance_position)
    simple = replace(suspects, effects=[e for e in suspects.effects if len(e.fitted_specs()) <= 1])
    names = [kind_and_place(effect) for effect in elements.effects]
    steps: list[AcceptedEffect] = []
    for i, effect in enumerate(elements.effects):
        stage = part(progress, i / len(names), (i + 1) / len(names))
        accompanying = tuple(e for j, e in enumerate(elements.effects) if j != i)
        folded = predictor.folded_into_matrices(accompanying)
        rivals = fit_candidates(folded, fit(folded, ()), simple, progress=stage)
        accepted = fit(predictor, (*accompanying, effect))
        rivals = [rival for rival in rivals if kind_and_place(rival.effects[-1]) not in names]
        steps.append(AcceptedEffect(names[i], start, accepted, (accepted, *rivals)))
    return SearchPath(start, tuple(steps))
