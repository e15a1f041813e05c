"""Adds the effect that explains most, until only random error is left or no effect explains more."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.stats import chi2

from modallab.core.arrays import BoolArray
from modallab.core.place import Channels
from modallab.core.progress import Progress
from modallab.diagnosis.evidence import gather
from modallab.diagnosis.fitting import Fit, approach, fit
from modallab.diagnosis.observed import Observed
from modallab.diagnosis.predictor import Predictor
from modallab.diagnosis.residual import Residual, correlations, scatter, scatters
from modallab.diagnosis.scanning import scan
from modallab.rig.effect import Effect

FITTED = 6  # candidates of a round that are fitted in full
BRANCHES = 3  # first effects that are followed up where the best one does not explain most
MOST = 3.0  # gap of a part above which the best first effect may be the wrong one of two
CONVINCING = 10.0  # difference in BIC that counts as very strong (Kass and Raftery 1995)
ALIKE = 9.0  # difference in chi-square within which two explanations cannot be told apart
ROUNDING = 0.1  # difference in BIC of two descriptions of one and the same physics
LINES_APART = 4  # lines of a channel that are held out: every so many
CLEAR = 2.0  # standard errors that a parameter keeps from `absent`
CHANCE = 3e-5  # probability below which a gap above 1 is not put down to chance: four standard errors


@dataclass(frozen=True, eq=False)
class Accepted:
    """One effect that was added: the fit with it, the fit before, and what else was tried."""

    kind_and_place: tuple[str, str]
    before: Fit
    after: Fit
    tried: tuple[Fit, ...]  # each with the new effect last, best first


@dataclass(frozen=True, eq=False)
class Path:
    """Effects added one after the other."""

    start: Fit
    steps: tuple[Accepted, ...] = field(default=())

    @property
    def fit(self) -> Fit:
        """The fit with everything that was added."""
        return self.steps[-1].after if self.steps else self.start


def only_noise_left(predictor: Predictor, left: Residual) -> bool:
    """Return whether every part of the gap is 1 within its scatter, fitted and held out alike."""
    observed = predictor.observed
    for where in (observed.fitted, observed.kept):
        errors = scatters(observed, left, where)
        if any(gap > highest_by_chance(errors[part]) for part, gap in left.gaps(where).items()):
            return False
    return True


def highest_by_chance(error: float) -> float:
    """Return the largest gap that counts as 1, of a gap's random error if nothing is missing.

    A mean of squares is chi-square with 2 / error^2 degrees of freedom: with few of them, as leakage
    leaves, it reaches further up than a normal number of the same scatter.
    """
    freedom = 2 / error**2
    return float(chi2.isf(CHANCE, freedom) / freedom)


@dataclass(frozen=True)
class Suspects:
    """What may be missing, one effect a kind and place; below a suspicion of `least` passed over."""

    effects: Sequence[Effect]
    least: float = 0.0

    def of(self, predictor: Predictor, accepted: Sequence[Effect]) -> list[Effect]:
        """Return those that what disagrees with some effects accepted points at, the likeliest first."""
        evidence = gather(predictor, accepted)
        likely = {cls: cls.signature(evidence) for cls in {type(effect) for effect in self.effects}}
        left = [effect for effect in self.effects if likely[type(effect)] >= self.least]
        return sorted(left, key=lambda effect: -likely[type(effect)])


def search(predictor: Predictor, suspects: Suspects, *, max_effects: int, progress: Progress) -> Path:
    """Return the effects that explain the measurement, each better than noise could.

    Greedy, all accepted effects fitted together at every step; where the best first effect does not
    lead to a full explanation the next ones are followed up too, as the first of a pair need not be
    the one that alone explains most.
    """
    start = fit(predictor, ())
    if only_noise_left(predictor, start.residual):
        return Path(start)
    progress(0.05, f"gap {start.residual.gap(predictor.observed.fitted):.3g}")
    first = trials(predictor, start, suspects, progress=_part(progress, 0.05, 0.5))
    paths: list[Path] = []
    for i, candidate in enumerate(first[:BRANCHES]):
        if not improves(predictor, start, candidate):
            break
        step = Accepted(_name(candidate.effects[-1]), start, candidate, tuple(first))
        whole = _part(progress, 0.5 + 0.15 * i, 0.65 + 0.15 * i)
        paths.append(_extended(predictor, Path(start, (step,)), suspects, max_effects, whole))
        if only_noise_left(predictor, paths[-1].fit.residual):
            return _ordered(predictor, _pruned(predictor, paths[-1]))
        gaps = paths[-1].fit.residual.gaps(predictor.observed.fitted)
        if max_effects == 1 or max(gaps.values()) < MOST:
            break
    if not paths:
        return Path(start)
    best = paths[0]  # unless another is better beyond what chance and an incomplete model feign
    for path in paths[1:]:
        if path.fit.bic < best.fit.bic - CONVINCING * temperature(predictor, best.fit):
            best = path
    return _ordered(predictor, _pruned(predictor, best))


def trials(predictor: Predictor, base: Fit, suspects: Suspects, *, progress: Progress) -> list[Fit]:
    """Return fits of the accepted effects with one suspect more, best first, one a kind and place."""
    accepted = base.effects
    glimpses = predictor.near(accepted)
    likely = suspects.of(predictor, accepted)
    starts = scan(glimpses, accepted, likely, _part(progress, 0.0, 0.5))
    near: dict[tuple[str, str], tuple[float, Effect]] = {}
    for i, start in enumerate(starts):
        progress(0.5 + 0.25 * i / len(starts), f"approaching {start.effect.kind}")
        effect, cost = approach(glimpses, accepted, start.effect, start.widening)
        if _name(effect) not in near or cost < near[_name(effect)][0]:
            near[_name(effect)] = (cost, effect)
    best = sorted(near.values(), key=lambda pair: pair[0])[:FITTED]
    fits = []
    for i, (_, effect) in enumerate(best):
        progress(0.75 + 0.25 * i / len(best), f"fitting {effect.kind}")
        fits.append(fit(predictor, (*accepted, effect)))
    return best_first(fits)


def best_first(fits: Sequence[Fit]) -> list[Fit]:
    """Return fits by BIC; of those that differ by rounding alone what belongs to the rig comes first.

    A rig is changed from test to test, a model is not: the likelier place for what was forgotten.
    """
    order = sorted(fits, key=lambda one: one.bic)
    tied = [one for one in order if one.bic - order[0].bic < ROUNDING]
    return sorted(tied, key=lambda one: one.effects[-1].structural) + order[len(tied) :]


def improves(predictor: Predictor, before: Fit, after: Fit) -> bool:
    """Return whether an added effect is convincing: by BIC, on what was held out, and by its size."""
    observed = predictor.observed
    if before.bic - after.bic < CONVINCING * temperature(predictor, after):
        return False
    effect, errors = after.effects[-1], after.errors[-1]
    for name, spec in effect.specs().items():
        if spec.absent is not None and abs(effect.parameters[name] - spec.absent) < CLEAR * errors[name]:
            return False
    where = observed.kept
    if (alone := _known_to_no_other(observed, effect)) is not None:
        # No other FRF can bear it out: it has to predict lines of its own that it was not fitted to.
        predictor = predictor.without_lines(LINES_APART)
        where = observed.usable & predictor.observed.held_lines[:, None] & alone
        after = fit(predictor, after.effects)
    held_before, held_after = (f.residual.gap(where) for f in (before, after))
    return held_after < held_before - scatter(observed, after.residual, where)


def _known_to_no_other(observed: Observed, effect: Effect) -> BoolArray | None:
    """Return the channels (n_out,) an effect acts on, if it leaves all that are held out as they were."""
    if not isinstance(effect.at, Channels):
        return None
    alone = np.array([effect.acts_on(dof) for dof in observed.outputs])
    held = observed.held_out
    return alone if held.any() and not (alone & held).any() else None


def temperature(predictor: Predictor, best: Fit) -> float:
    """Return by how much chi-square overstates a difference: correlated lines, or an incomplete model."""
    observed = predictor.observed
    lines = max(correlations(observed, best.residual).values())
    return lines * max(1.0, best.chi_square / best.n_data)


def _extended(
    predictor: Predictor, path: Path, suspects: Suspects, max_effects: int, progress: Progress
) -> Path:
    while len(path.steps) < max_effects and not only_noise_left(predictor, path.fit.residual):
        found = trials(predictor, path.fit, suspects, progress=progress)
        if not found or not improves(predictor, path.fit, found[0]):
            break
        step = Accepted(_name(found[0].effects[-1]), path.fit, found[0], tuple(found))
        path = Path(path.start, (*path.steps, step))
    return path


def _pruned(predictor: Predictor, path: Path) -> Path:
    """Return the path without effects that those added later made needless."""
    if len(path.steps) < 2:
        return path
    for i in range(len(path.steps) - 1):
        rest = tuple(e for j, e in enumerate(path.fit.effects) if j != i)
        without = fit(predictor, rest)
        if without.bic < path.fit.bic + CONVINCING:
            kept = [s for j, s in enumerate(path.steps) if j != i]
            last = Accepted(kept[-1].kind_and_place, kept[-1].before, without, kept[-1].tried)
            return _pruned(predictor, Path(path.start, (*kept[:-1], last)))
    return path


def _ordered(predictor: Predictor, path: Path) -> Path:
    """Return the path with the effect first that explains most beside all the others."""
    if len(path.steps) < 2:
        return path
    effects, where = path.fit.effects, predictor.observed.fitted
    without = []
    for i in range(len(effects)):
        left = predictor.residual([e for j, e in enumerate(effects) if j != i]).vector(where)
        without.append(float(left @ left))
    tried = {step.kind_and_place: step.tried for step in path.steps}
    steps: list[Accepted] = []
    before = path.start
    order = sorted(range(len(effects)), key=lambda i: -without[i])
    for n in range(1, len(order) + 1):
        name = _name(effects[order[n - 1]])
        after = fit(predictor, [effects[i] for i in order[:n]])
        steps.append(Accepted(name, before, after, tried[name]))
        before = after
    return Path(path.start, tuple(steps))


def _name(effect: Effect) -> tuple[str, str]:
    return effect.kind, str(effect.at)


def _part(progress: Progress, low: float, high: float) -> Progress:
    return lambda fraction, message: progress(low + (high - low) * fraction, message)


def probabilities(predictor: Predictor, fits: Sequence[Fit]) -> list[float]:
    """Return the share of belief of each fit among all, by BIC."""
    scale = temperature(predictor, fits[0])
    weight = np.exp(-0.5 * np.array([f.bic - fits[0].bic for f in fits]) / scale)
    return [float(w) for w in weight / weight.sum()]
