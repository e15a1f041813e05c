"""One round of the search: every suspect beside what was accepted, the best of them fitted in full."""

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass

from modallab.core.errors import InvalidInputError
from modallab.core.progress import Progress, part
from modallab.diagnosis.fitting.fit import Fit, approach, fit
from modallab.diagnosis.locating.evidence import gather
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.judging import best_first
from modallab.diagnosis.searching.path import name_of
from modallab.diagnosis.searching.scanning import scan
from modallab.rig.effect import Effect

FITTED = 6  # candidates of a round that are fitted in full
PLACES_FITTED = 3  # of them that may be of one kind


@dataclass(frozen=True)
class Suspects:
    """What may be missing, one effect a kind and place; below a suspicion of `least` passed over."""

    effects: Sequence[Effect]
    least: float = 0.0

    def of(self, predictor: Predictor, accepted: Sequence[Effect]) -> list[Effect]:
        """Return those that what disagrees with some effects accepted points at, the likeliest first."""
        # What shows at one level or drive point need not show at the others.
        every = [gather(test, accepted) for test in predictor.tests]
        kinds = {type(effect) for effect in self.effects}
        likely = {cls: max(cls.signature(evidence) for evidence in every) for cls in kinds}
        taken = {name_of(effect) for effect in accepted}
        left = [
            effect
            for effect in self.effects
            if likely[type(effect)] >= self.least and name_of(effect) not in taken
        ]
        return sorted(left, key=lambda effect: -likely[type(effect)])


def trials(predictor: Predictor, base: Fit, suspects: Suspects, *, progress: Progress) -> list[Fit]:
    """Return fits of the accepted effects with one suspect more, best first, one a kind and place."""
    accepted, predictor = base.effects, predictor.tolerating(base.outlook)
    glimpses = predictor.near(accepted)
    likely = suspects.of(predictor, accepted)
    starts = scan(glimpses, accepted, likely, part(progress, 0.0, 0.5))
    near: dict[tuple[str, str], tuple[float, Effect]] = {}
    for i, start in enumerate(starts):
        progress(0.5 + 0.25 * i / len(starts), f"approaching {start.effect.kind}")
        with suppress(InvalidInputError):  # what cannot be predicted cannot be what was measured
            effect, cost = approach(glimpses, accepted, start.effect, start.widening)
            if name_of(effect) not in near or cost < near[name_of(effect)][0]:
                near[name_of(effect)] = (cost, effect)
    best = _worth_fitting(near.values())
    fits = []
    for i, effect in enumerate(best):
        progress(0.75 + 0.25 * i / len(best), f"fitting {effect.kind}")
        with suppress(InvalidInputError):
            fits.append(fit(predictor, (*accepted, effect)))
    return best_first(fits)


def _worth_fitting(near: Iterable[tuple[float, Effect]]) -> list[Effect]:
    """Return the effects that left least on first looks: the best places of several kinds."""
    chosen: list[Effect] = []
    for _, effect in sorted(near, key=lambda pair: pair[0]):
        alike = sum(one.kind == effect.kind for one in chosen)
        if len(chosen) < FITTED and alike < PLACES_FITTED:
            chosen.append(effect)
    return chosen
