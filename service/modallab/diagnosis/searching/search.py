"""Adds the effect that explains most, until only random error is left or no effect explains more."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice

from modallab.core.progress import Progress, part
from modallab.diagnosis.fitting.fit import Fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.judging import (
    CONVINCING,
    improves,
    only_noise_left,
    temperature,
)
from modallab.diagnosis.searching.path import Accepted, Path, name_of, put_right
from modallab.diagnosis.searching.several import PAIR, borne_out, several_elements
from modallab.diagnosis.searching.trials import Suspects, trials

BRANCHES = 3  # first effects, of as many kinds, that are followed up by a second one
MUCH = 0.5  # of what was above 1 that an effect leaves at most where a third one is worth looking for


def search(
    predictor: Predictor, start: Fit, suspects: Suspects, *, max_effects: int, progress: Progress
) -> Path:
    """Return the effects that explain the measurement, each better than noise could.

    Greedy, all accepted effects fitted together at every step. The first of a pair need not be the one
    that alone explains most: where it and the best second one are not a full explanation, the best of
    other kinds are followed up by a second effect too, and the best pair is where the search goes on.

    Parameters
    ----------
    start
        The fit without any effect.
    """
    if only_noise_left(predictor, start.residual):
        return Path(start)
    progress(0.05, f"gap {start.residual.gap(predictor.observed.fitted):.3g}")
    first = trials(predictor, start, suspects, progress=part(progress, 0.05, 0.25))
    elements = None
    if first and not only_noise_left(predictor, first[0].residual):
        looking = part(progress, 0.25, 0.3)
        elements = several_elements(predictor, first[0], suspects, max_effects=max_effects, progress=looking)
    if elements and len(elements.effects) <= PAIR:
        return put_right(
            predictor, borne_out(predictor, start, elements, suspects, part(progress, 0.3, 0.95))
        )
    paths: list[Path] = []
    for i, (candidate, tried) in enumerate(islice(convincing(predictor, start, first), BRANCHES)):
        name = name_of(candidate.effects[-1])
        if any(name == step.kind_and_place for path in paths for step in path.steps):
            continue
        single = Path(start, (Accepted(name, start, candidate, tried),))
        whole = part(progress, 0.3 + 0.15 * i, 0.45 + 0.15 * i)
        paths.append(_longer(predictor, single, suspects, min(PAIR, max_effects), whole))
        if max_effects == 1 or only_noise_left(predictor, paths[-1].fit.residual):
            return put_right(predictor, paths[-1])
        if predictor.effort.over:
            break
    if elements:  # no pair explains it, so they are worth their number
        return put_right(
            predictor, borne_out(predictor, start, elements, suspects, part(progress, 0.75, 0.95))
        )
    if not paths:
        return Path(start)
    best = paths[0]  # unless another is better beyond what chance and an incomplete model feign
    for path in paths[1:]:
        if path.fit.bic < best.fit.bic - CONVINCING * temperature(predictor, best.fit):
            best = path
    best = _longer(predictor, best, suspects, max_effects, part(progress, 0.75, 0.95))
    return put_right(predictor, best)


def convincing(
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
        if improves(predictor, before, one):
            yield one, left
        else:
            left = tuple(fit for fit in left if fit.effects[-1].kind != kind)


def _longer(
    predictor: Predictor, path: Path, suspects: Suspects, max_effects: int, progress: Progress
) -> Path:
    """Return a path with effects added up to so many, as long as each is convincing and one is missing.

    Beyond a second one as long as the last closed much of the gap: what a catalogue lacks can be feigned
    little by little by many effects, none of which is there.
    """
    while len(path.steps) < max_effects and not (path.ended or only_noise_left(predictor, path.fit.residual)):
        if predictor.effort.over or (len(path.steps) > 1 and not _closes_much(predictor, path.steps[-1])):
            break
        found = trials(predictor, path.fit, suspects, progress=progress)
        best = next(convincing(predictor, path.fit, found), None)
        if best is None:
            return replace(path, ended=True)
        step = Accepted(name_of(best[0].effects[-1]), path.fit, *best)
        path = Path(path.start, (*path.steps, step))
    return path


def _closes_much(predictor: Predictor, step: Accepted) -> bool:
    where = predictor.observed.fitted
    before, after = (one.residual.gap(where) - 1 for one in (step.before, step.after))
    return after < MUCH * before
