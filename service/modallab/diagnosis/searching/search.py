"""Forward selection of effects until only random error is left or no effect is significant."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import islice

from modallab.core.progress import Progress, part
from modallab.diagnosis.fitting.fit import Fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import is_significant, variance_inflation
from modallab.diagnosis.searching.common_deviation import with_common_deviation
from modallab.diagnosis.searching.equivalent_fits import without_undetermined_effects
from modallab.diagnosis.searching.gap_tests import excess_ratio, has_no_lack_of_fit, is_noise_only
from modallab.diagnosis.searching.multiple_elements import multiple_elements, verify
from modallab.diagnosis.searching.round_settings import ROUND
from modallab.diagnosis.searching.search_path import (
    AcceptedEffect,
    SearchPath,
    kind_and_place,
    refine_path,
    with_optional_parameters_of_all,
)
from modallab.diagnosis.searching.search_round import fit_candidates
from modallab.diagnosis.searching.settings import ACCEPTANCE, SEARCH
from modallab.diagnosis.searching.suspects import Suspects
from modallab.rig.effect import Effect, is_nonlinear

ExplanationCriterion = Callable[[tuple[Effect, ...]], bool]
"""Whether effects leave random error alone under tolerances that a later search may assume."""


def search(
    predictor: Predictor,
    start: Fit,
    suspects: Suspects,
    *,
    max_effects: int,
    progress: Progress,
    first_round: Sequence[Fit] | None = None,
    explains: ExplanationCriterion | None = None,
) -> SearchPath:
    """Return the effects that explain the measurement, each of them significant.

    Forward selection, all accepted effects fitted together at every step. The first effect of a pair need
    not be the best single one: unless that one and its best second effect are a full explanation, the best
    effects of other kinds are followed by a second effect too, and the search continues from the best pair.
    Where the best one closes little, which the larger effect of a pair does not, the others are left out.

    Parameters
    ----------
    start
        The fit without any effect.
    first_round
        The fits of single effects by `fit_candidates`, if they are known.
    explains
        Whether effects leave random error alone under tolerances assumed later. Such a pair ends the search:
        a third effect would absorb what the tolerances explain.
    """
    if is_noise_only(predictor, start):
        return with_common_deviation(predictor, start, suspects)
    progress(0.05, f"gap {start.residual.gap(predictor.observed.fitted):.3g}")
    first = first_round
    if first is None:
        first = fit_candidates(predictor, start, suspects, progress=part(progress, 0.05, 0.25))
    elements = None
    if first and max_effects > 1 and not has_no_lack_of_fit(predictor, start, first[0]):
        stage = part(progress, 0.25, 0.3)
        elements = multiple_elements(predictor, first[0], suspects, max_effects=max_effects, progress=stage)
    if elements and len(elements.effects) <= SEARCH.pair:
        stage = part(progress, 0.3, 0.95)
        return refine_path(predictor, verify(predictor, start, elements, suspects, stage))
    paths = _branches(predictor, start, first, suspects, max_effects, progress, explains)
    if paths and (max_effects == 1 or _is_complete(predictor, paths[-1], explains)):
        return refine_path(predictor, paths[-1])
    if elements:  # no pair explains the measurement, so that more elements are justified
        stage = part(progress, 0.75, 0.95)
        return refine_path(predictor, verify(predictor, start, elements, suspects, stage))
    if not paths:
        return SearchPath(start)
    best = paths[0]  # unless another is better beyond chance and the error of an incomplete model
    for path in paths[1:]:
        margin = ACCEPTANCE.very_strong_bic * variance_inflation(predictor, best.fit)
        if path.fit.bic < best.fit.bic - margin:
            best = path
    best = _extended(predictor, best, suspects, max_effects, part(progress, 0.75, 0.95), explains)
    return without_undetermined_effects(predictor, refine_path(predictor, best))


def _branches(
    predictor: Predictor,
    start: Fit,
    first: Sequence[Fit],
    suspects: Suspects,
    max_effects: int,
    progress: Progress,
    explains: ExplanationCriterion | None,
) -> list[SearchPath]:
    """Return paths of one or two effects, one for each of the best kinds; the last may leave only noise."""
    paths: list[SearchPath] = []
    branches = islice(significant_fits(predictor, start, first), SEARCH.max_branches)
    for i, (candidate, round_fits) in enumerate(branches):
        if paths and candidate.chi_square > ROUND.competitive_cost * first[0].chi_square:
            break
        name = kind_and_place(candidate.effects[-1])
        if any(name == step.kind_and_place for path in paths for step in path.steps):
            continue
        single = SearchPath(start, (AcceptedEffect(name, start, candidate, round_fits),))
        stage = part(progress, 0.3 + 0.15 * i, 0.45 + 0.15 * i)
        paths.append(_extended(predictor, single, suspects, min(SEARCH.pair, max_effects), stage, explains))
        if max_effects == 1 or _is_complete(predictor, paths[-1], explains):
            break
        if predictor.budget.exhausted or _closes_little(predictor, paths[-1].steps[0]):
            break
    return paths


def significant_fits(
    predictor: Predictor, previous: Fit, fits: Sequence[Fit]
) -> Iterator[tuple[Fit, tuple[Fit, ...]]]:
    """Yield the best significant fit of each kind, best first, with the remaining fits of its round.

    A fit that is not significant excludes its kind, not the fits after it.
    """
    best: dict[str, Fit] = {}
    for candidate in fits:
        best.setdefault(candidate.effects[-1].kind, candidate)
    remaining = tuple(fits)
    for kind, candidate in best.items():
        if is_significant(predictor, previous, candidate):
            yield candidate, remaining
        else:
            remaining = tuple(fit for fit in remaining if fit.effects[-1].kind != kind)


def _extended(
    predictor: Predictor,
    path: SearchPath,
    suspects: Suspects,
    max_effects: int,
    progress: Progress,
    explains: ExplanationCriterion | None,
) -> SearchPath:
    """Return a path with effects added, as long as each is significant and one is missing.

    Beyond the second one only if the last closed much of the gap: many effects together can imitate, little
    by little, one that is not in the catalogue.
    """
    while len(path.steps) < max_effects:
        if path.exhausted or _is_complete(predictor, path, explains) or predictor.budget.exhausted:
            break
        if len(path.steps) > 1 and not _closes_much(predictor, path.steps[-1]):
            break
        candidates = fit_candidates(predictor, path.fit, suspects, progress=progress)
        best = next(significant_fits(predictor, path.fit, candidates), None)
        if best is None:
            return replace(path, exhausted=True)
        step = AcceptedEffect(kind_and_place(best[0].effects[-1]), path.fit, *best)
        path = SearchPath(path.start, (*path.steps, step))
        if not is_noise_only(predictor, path.fit):
            path = with_optional_parameters_of_all(predictor, path)
    return path


def _is_complete(predictor: Predictor, path: SearchPath, explains: ExplanationCriterion | None) -> bool:
    """Return whether no effect is missing: what is left is noise, an error of predictions, or tolerated."""
    if has_no_lack_of_fit(predictor, path.start, path.fit) or is_prediction_error(predictor, path):
        return True
    if explains is None or len(path.steps) < SEARCH.pair:  # of single effects the first round asked already
        return False
    return _closes_much(predictor, path.steps[-1]) and explains(path.fit.effects)


def _closes_much(predictor: Predictor, step: AcceptedEffect) -> bool:
    return excess_ratio(step.previous_fit, step.fit, predictor.observed.fitted) < SEARCH.closing_ratio


def _closes_little(predictor: Predictor, step: AcceptedEffect) -> bool:
    """Return whether an effect closes so little that those after it are no first effects of a pair either."""
    return excess_ratio(step.previous_fit, step.fit, predictor.observed.fitted) > SEARCH.branching_ratio


def is_prediction_error(predictor: Predictor, path: SearchPath) -> bool:
    """Return whether what is left may be the error of predictions with a strong nonlinear force.

    Simulated tests show how far spectra are from their equivalent linearisation. A force that closes all but
    a small share of the gap leaves no more than that.
    """
    found, mask = path.fit, predictor.observed.fitted
    if found.residual.variance_ratios is None or not is_nonlinear(found.effects):
        return False
    scatter = float(found.residual.variance_ratios().response[mask].mean())
    closed = excess_ratio(path.start, found, predictor.observed.fitted) < SEARCH.prediction_error
    return scatter > SEARCH.strong_scatter and closed
