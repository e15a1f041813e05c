"""Adds the effect that explains most, until only random error is left or no effect explains more."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice

from modallab.core.progress import Progress, part
from modallab.diagnosis.fitting.fit import Fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import (
    CONVINCING,
    is_noise_only,
    is_significant,
    variance_inflation,
)
from modallab.diagnosis.searching.multiple_elements import PAIR, multiple_elements, verify
from modallab.diagnosis.searching.search_path import AcceptedEffect, SearchPath, kind_and_place, refine_path
from modallab.diagnosis.searching.search_round import Suspects, fit_candidates

BRANCHES = 3  # first effects, of as many kinds, that are followed up by a second one
MUCH = 0.5  # of what was above 1 that an effect leaves at most where a third one is worth looking for


def search(
    predictor: Predictor, start: Fit, suspects: Suspects, *, max_effects: int, progress: Progress
) -> SearchPath:
    """Return the effects that explain the measurement, each better than noise could.

    Greedy, all accepted effects fitted together at every step. The first of a pair need not be the one
    that alone explains most: where it and the best second one are not a full explanation, the best of
    other kinds are followed up by a second effect too, and the best pair is where the search goes on.

    Parameters
    ----------
    start
        The fit without any effect.
    """
    if is_noise_only(predictor, start.residual):
        return SearchPath(start)
    progress(0.05, f"gap {start.residual.gap(predictor.observed.fitted):.3g}")
    first = fit_candidates(predictor, start, suspects, progress=part(progress, 0.05, 0.25))
    elements = None
    if first and not is_noise_only(predictor, first[0].residual):
        looking = part(progress, 0.25, 0.3)
        elements = multiple_elements(predictor, first[0], suspects, max_effects=max_effects, progress=looking)
    if elements and len(elements.effects) <= PAIR:
        return refine_path(predictor, verify(predictor, start, elements, suspects, part(progress, 0.3, 0.95)))
    paths: list[SearchPath] = []
    for i, (candidate, tried) in enumerate(islice(significant_fits(predictor, start, first), BRANCHES)):
        name = kind_and_place(candidate.effects[-1])
        if any(name == step.kind_and_place for path in paths for step in path.steps):
            continue
        single = SearchPath(start, (AcceptedEffect(name, start, candidate, tried),))
        whole = part(progress, 0.3 + 0.15 * i, 0.45 + 0.15 * i)
        paths.append(_longer(predictor, single, suspects, min(PAIR, max_effects), whole))
        if max_effects == 1 or is_noise_only(predictor, paths[-1].fit.residual):
            return refine_path(predictor, paths[-1])
        if predictor.budget.exhausted:
            break
    if elements:  # no pair explains it, so they are worth their number
        return refine_path(
            predictor, verify(predictor, start, elements, suspects, part(progress, 0.75, 0.95))
        )
    if not paths:
        return SearchPath(start)
    best = paths[0]  # unless another is better beyond what chance and an incomplete model feign
    for path in paths[1:]:
        if path.fit.bic < best.fit.bic - CONVINCING * variance_inflation(predictor, best.fit):
            best = path
    best = _longer(predictor, best, suspects, max_effects, part(progress, 0.75, 0.95))
    return refine_path(predictor, best)


def significant_fits(
    predictor: Predictor, before: Fit, fits: Sequence[Fit]
) -> Iterator[tuple[Fit, tuple[Fit, ...]]]:
    """Yield the best fit of each kind that is convincing, in order, with what else its round leaves open.

    What explains most but is not told from nothing, or not borne out, hides none of those behind it.
    """
    best: dict[str, Fit] = {}
    for one in fits:
        best.setdefault(one.effects[-1].kind, one)
    left = tuple(fits)
    for kind, one in best.items():
        if is_significant(predictor, before, one):
            yield one, left
        else:
            left = tuple(fit for fit in left if fit.effects[-1].kind != kind)


def _longer(
    predictor: Predictor, path: SearchPath, suspects: Suspects, max_effects: int, progress: Progress
) -> SearchPath:
    """Return a path with effects added up to so many, as long as each is convincing and one is missing.

    Beyond a second one as long as the last closed much of the gap: what a catalogue lacks can be feigned
    little by little by many effects, none of which is there.
    """
    while len(path.steps) < max_effects and not (
        path.exhausted or is_noise_only(predictor, path.fit.residual)
    ):
        if predictor.budget.exhausted or (
            len(path.steps) > 1 and not _closes_much(predictor, path.steps[-1])
        ):
            break
        found = fit_candidates(predictor, path.fit, suspects, progress=progress)
        best = next(significant_fits(predictor, path.fit, found), None)
        if best is None:
            return replace(path, exhausted=True)
        step = AcceptedEffect(kind_and_place(best[0].effects[-1]), path.fit, *best)
        path = SearchPath(path.start, (*path.steps, step))
    return path


def _closes_much(predictor: Predictor, step: AcceptedEffect) -> bool:
    where = predictor.observed.fitted
    before, after = (one.residual.gap(where) - 1 for one in (step.previous_fit, step.fit))
    return after < MUCH * before
