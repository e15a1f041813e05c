"""Path of a search: effects accepted one after the other, and the refinement of their choice and order."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

from modallab.core.errors import InvalidInputError
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import ranked_by_bic
from modallab.diagnosis.searching.equivalent_values import resolve_equivalents
from modallab.diagnosis.searching.gap_tests import excess_ratio, is_noise_only
from modallab.diagnosis.searching.neighbouring_places import neighbouring_effects
from modallab.diagnosis.searching.round_settings import ROUND
from modallab.diagnosis.searching.settings import ACCEPTANCE, SEARCH
from modallab.rig.effect import Effect


@dataclass(frozen=True, eq=False)
class AcceptedEffect:
    """One added effect."""

    kind_and_place: tuple[str, str]
    """Kind and place of the effect."""
    previous_fit: Fit
    """The fit without the effect."""
    fit: Fit
    """The fit with the effect."""
    round_fits: tuple[Fit, ...]
    """The fits of its round, each with the new effect last, best first."""


@dataclass(frozen=True, eq=False)
class SearchPath:
    """Effects added one after the other."""

    start: Fit
    """The fit without any effect."""
    steps: tuple[AcceptedEffect, ...] = field(default=())
    """The added effects."""
    exhausted: bool = False
    """Whether no further effect is significant."""

    @property
    def fit(self) -> Fit:
        """The fit with all added effects."""
        return self.steps[-1].fit if self.steps else self.start


def kind_and_place(effect: Effect) -> tuple[str, str]:
    """Return kind and place, which identify an effect whatever its parameters."""
    return effect.kind, str(effect.at)


def refine_path(predictor: Predictor, path: SearchPath) -> SearchPath:
    """Return a path without superfluous effects, each the best beside all others, the largest first."""
    pruned = _pruned(predictor, path)
    path = _exchanged(predictor, pruned)
    if len(path.steps) > 1 and _closes_most(predictor, path):
        path = with_optional_parameters_of_all(predictor, path)
    if path.fit.chi_square < pruned.fit.chi_square:
        path = _pruned(predictor, path)
    path = _ordered(predictor, path)
    if not path.steps:
        return path
    last = replace(path.steps[-1], fit=resolve_equivalents(predictor, path.fit))
    return replace(path, steps=(*path.steps[:-1], last))


def with_optional_parameters_of_all(predictor: Predictor, path: SearchPath) -> SearchPath:
    """Return the path with the optional parameters and other choices of its effects, if BIC is lower.

    While another effect was missing they may not have been.
    """
    best = path.fit
    predictor = predictor.with_nuisances_at(best.nuisance_position)
    for i in range(len(best.effects)):
        before, after = best.effects[:i], best.effects[i + 1 :]
        for variant in best.effects[i].variants(predictor.system):
            extended = fit(predictor, (*before, variant, *after), near=path.start)
            best = min(best, extended, key=lambda found: found.bic)
    return replace(path, steps=(*path.steps[:-1], replace(path.steps[-1], fit=best)))


def _pruned(predictor: Predictor, path: SearchPath) -> SearchPath:
    """Return the path without effects that others made superfluous: backward elimination."""
    if len(path.steps) < 2:
        return path
    predictor = predictor.with_nuisances_at(path.fit.nuisance_position)
    for i in range(len(path.steps)):
        remaining = tuple(e for j, e in enumerate(path.fit.effects) if j != i)
        reduced = fit(predictor, remaining)
        if reduced.bic < path.fit.bic + ACCEPTANCE.very_strong_bic:
            steps = [s for j, s in enumerate(path.steps) if j != i]
            steps[-1] = replace(steps[-1], fit=reduced)
            return _pruned(predictor, SearchPath(path.start, tuple(steps)))
    return path


def _exchanged(predictor: Predictor, path: SearchPath) -> SearchPath:
    """Return the path with each effect compared with the others of its round, beside all later effects.

    The best effect while another was missing need not be the best one now. Where the search was given up
    and much of the gap is left, one is missing still.
    """
    if len(path.steps) < 2 or (predictor.budget.exhausted and not _closes_most(predictor, path)):
        return path
    best, steps = path.fit, list(path.steps)
    for i, step in enumerate(steps):
        predictor = predictor.with_nuisances_at(best.nuisance_position)
        own_effect = next(e for e in best.effects if kind_and_place(e) == step.kind_and_place)
        accompanying = tuple(effect for effect in best.effects if effect is not own_effect)
        names = {kind_and_place(effect) for effect in best.effects}
        rivals = [f.effects[-1] for f in step.round_fits if kind_and_place(f.effects[-1]) not in names]
        fits = [
            fit(predictor, (*accompanying, effect))
            for effect in (own_effect, *rivals[: SEARCH.max_exchanges])
        ]
        order = ranked_by_bic(fits)
        if not is_noise_only(predictor, order[0]):
            order = ranked_by_bic(_with_neighbours(predictor, accompanying, order))
        best = order[0]
        name = kind_and_place(best.effects[-1])
        steps[i] = replace(step, kind_and_place=name, fit=best, round_fits=tuple(order))
    steps[-1] = replace(steps[-1], fit=best)
    return SearchPath(path.start, tuple(steps))


def _with_neighbours(predictor: Predictor, accompanying: Sequence[Effect], fits: Sequence[Fit]) -> list[Fit]:
    """Return the fits, and further ones at the places that adjoin the best of each of the first kinds.

    Places are followed as long as a fit improves: the place that was best while another effect was missing
    may be next to the true one.

    Parameters
    ----------
    accompanying
        The other effects.
    fits
        With one effect more, the last one; best first.
    """
    found = {kind_and_place(each.effects[-1]): each for each in fits}
    taken = {kind_and_place(effect) for effect in accompanying}
    for kind in list(dict.fromkeys(each.effects[-1].kind for each in fits))[: ROUND.kinds_at_neighbours]:
        last = None
        while (best := _least(found, kind)) is not last:
            last, limit = best, ROUND.competitive_cost * best.chi_square
            for effect in neighbouring_effects(best.effects[-1], predictor.system):
                name = kind_and_place(effect)
                if name not in found and name not in taken:
                    with suppress(InvalidInputError):  # where the structure has no place for it
                        found[name] = fit(predictor, (*accompanying, effect), max_chi_square=limit)
    return list(found.values())


def _least(found: Mapping[tuple[str, str], Fit], kind: str) -> Fit:
    """Return the fit of least chi-square with an effect of a kind."""
    return min((each for (own, _), each in found.items() if own == kind), key=lambda each: each.chi_square)


def _closes_most(predictor: Predictor, path: SearchPath) -> bool:
    """Return whether the effects leave little of the gap, or random error alone."""
    if is_noise_only(predictor, path.fit):
        return True
    return excess_ratio(path.start, path.fit, predictor.observed.fitted) <= SEARCH.most_excess


def _ordered(predictor: Predictor, path: SearchPath) -> SearchPath:
    """Return the path ordered by the chi-square without each effect, the largest first."""
    if len(path.steps) < 2:
        return path
    effects, mask = path.fit.effects, predictor.observed.fitted
    predictor = predictor.with_nuisances_at(path.fit.nuisance_position)
    squares = []
    for i in range(len(effects)):
        vector = predictor.residual([e for j, e in enumerate(effects) if j != i]).vector(mask)
        squares.append(float(vector @ vector))
    round_fits = {step.kind_and_place: step.round_fits for step in path.steps}
    steps: list[AcceptedEffect] = []
    previous = path.start
    order = sorted(range(len(effects)), key=lambda i: -squares[i])
    for n in range(1, len(order) + 1):
        name = kind_and_place(effects[order[n - 1]])
        current = fit(predictor, [effects[i] for i in order[:n]])
        steps.append(AcceptedEffect(name, previous, current, round_fits[name]))
        previous = current
    return SearchPath(path.start, tuple(steps))
