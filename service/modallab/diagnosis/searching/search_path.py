"""Effects that were accepted one after the other, and putting their order and choice right at the end."""

from dataclasses import dataclass, field, replace

from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import CONVINCING, ranked_by_bic
from modallab.diagnosis.searching.equivalent_values import resolve_equivalents
from modallab.rig.effect import Effect

EXCHANGED = 3  # other effects of its round that may take an effect's place


@dataclass(frozen=True, eq=False)
class AcceptedEffect:
    """One effect that was added: the fit with it, the fit before, and what else was tried."""

    kind_and_place: tuple[str, str]
    previous_fit: Fit
    fit: Fit
    round_fits: tuple[Fit, ...]  # each with the new effect last, best first


@dataclass(frozen=True, eq=False)
class SearchPath:
    """Effects added one after the other."""

    start: Fit
    steps: tuple[AcceptedEffect, ...] = field(default=())
    exhausted: bool = False  # nothing was found that could be added

    @property
    def fit(self) -> Fit:
        """The fit with everything that was added."""
        return self.steps[-1].fit if self.steps else self.start


def kind_and_place(effect: Effect) -> tuple[str, str]:
    """Return kind and place, which stand for an effect whatever its numbers."""
    return effect.kind, str(effect.at)


def refine_path(predictor: Predictor, path: SearchPath) -> SearchPath:
    """Return a path without needless effects, each the best beside all others, the largest first."""
    path = _ordered(predictor, _exchanged(predictor, _pruned(predictor, path)))
    if not path.steps:
        return path
    last = replace(path.steps[-1], fit=resolve_equivalents(predictor, path.fit))
    return replace(path, steps=(*path.steps[:-1], last))


def _pruned(predictor: Predictor, path: SearchPath) -> SearchPath:
    """Return the path without effects that those added later made needless."""
    if len(path.steps) < 2:
        return path
    predictor = predictor.with_nuisances_at(path.fit.nuisance_position)
    for i in range(len(path.steps) - 1):
        rest = tuple(e for j, e in enumerate(path.fit.effects) if j != i)
        without = fit(predictor, rest)
        if without.bic < path.fit.bic + CONVINCING:
            kept = [s for j, s in enumerate(path.steps) if j != i]
            last = AcceptedEffect(
                kept[-1].kind_and_place, kept[-1].previous_fit, without, kept[-1].round_fits
            )
            return _pruned(predictor, SearchPath(path.start, (*kept[:-1], last)))
    return path


def _exchanged(predictor: Predictor, path: SearchPath) -> SearchPath:
    """Return the path with each effect tried against the others of its round, beside all that came later.

    What explained most while something was missing besides need not be what explains it now. Where the search
    was given up something still is.
    """
    if len(path.steps) < 2 or predictor.budget.exhausted:
        return path
    best, steps = path.fit, list(path.steps)
    for i, step in enumerate(steps):
        predictor = predictor.with_nuisances_at(best.nuisance_position)
        own = next(effect for effect in best.effects if kind_and_place(effect) == step.kind_and_place)
        others = tuple(effect for effect in best.effects if effect is not own)
        taken = {kind_and_place(effect) for effect in best.effects}
        rivals = [one.effects[-1] for one in step.round_fits if kind_and_place(one.effects[-1]) not in taken]
        fits = [fit(predictor, (*others, effect)) for effect in (own, *rivals[:EXCHANGED])]
        order = ranked_by_bic(fits)
        best = order[0]
        steps[i] = replace(
            step, kind_and_place=kind_and_place(best.effects[-1]), fit=best, round_fits=tuple(order)
        )
    steps[-1] = replace(steps[-1], fit=best)
    return SearchPath(path.start, tuple(steps))


def _ordered(predictor: Predictor, path: SearchPath) -> SearchPath:
    """Return the path with the effect first that explains most beside all the others."""
    if len(path.steps) < 2:
        return path
    effects, where = path.fit.effects, predictor.observed.fitted
    predictor = predictor.with_nuisances_at(path.fit.nuisance_position)
    without = []
    for i in range(len(effects)):
        left = predictor.residual([e for j, e in enumerate(effects) if j != i]).vector(where)
        without.append(float(left @ left))
    tried = {step.kind_and_place: step.round_fits for step in path.steps}
    steps: list[AcceptedEffect] = []
    before = path.start
    order = sorted(range(len(effects)), key=lambda i: -without[i])
    for n in range(1, len(order) + 1):
        name = kind_and_place(effects[order[n - 1]])
        after = fit(predictor, [effects[i] for i in order[:n]])
        steps.append(AcceptedEffect(name, before, after, tried[name]))
        before = after
    return SearchPath(path.start, tuple(steps))
