"""One round of the search: every suspect beside what was accepted, the best of them fitted in full."""

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.place import Members
from modallab.core.progress import Progress, part
from modallab.diagnosis.fitting.coarse_fit import coarse_fit
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.fitting.settings import FIT
from modallab.diagnosis.localisation.evidence import collect_evidence
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import is_noise_only, ranked_by_bic
from modallab.diagnosis.searching.scanning import scan
from modallab.diagnosis.searching.search_path import kind_and_place
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import Effect

FITTED = 6  # candidates of a round that are fitted in full
PLACES_FITTED = 3  # of them that may be of one kind
LINEAR = 0.6  # of a round's time, roughly, that all but nonlinear forces take
SHOWN = 3  # that are fitted in any case, for whoever reads what else was thought of
HOPELESS = 2.0  # times what an explanation that leaves noise alone left on a first look: no rival comes back


@dataclass(frozen=True)
class Suspects:
    """What may be missing, one effect a kind and place; below a suspicion of `least` passed over."""

    effects: Sequence[Effect]
    least: float = 0.0

    def of(self, predictor: Predictor, accepted: Sequence[Effect]) -> list[Effect]:
        """Return those that what disagrees with some effects accepted points at, the likeliest first."""
        # What shows at one level or drive point need not show at the others.
        every = [collect_evidence(test, accepted) for test in predictor.tests]
        kinds = {type(effect) for effect in self.effects}
        likely = {cls: max(cls.signature(evidence) for evidence in every) for cls in kinds}
        taken = {kind_and_place(effect) for effect in accepted}
        left = [
            effect
            for effect in self.effects
            if likely[type(effect)] >= self.least and kind_and_place(effect) not in taken
        ]
        return sorted(left, key=lambda effect: -likely[type(effect)])


def fit_candidates(predictor: Predictor, base: Fit, suspects: Suspects, *, progress: Progress) -> list[Fit]:
    """Return fits of the accepted effects with one suspect more, best first, one a kind and place."""
    predictor = predictor.with_nuisances_at(base.starting_position)
    likely = suspects.of(predictor, base.effects)
    linear = [effect for effect in likely if effect.on_motion() is None]
    costly = [effect for effect in likely if effect.on_motion() is not None]
    share = LINEAR if costly else 1.0
    tried = _Round(predictor, base.effects)
    tried.look(linear, part(progress, 0.0, share))
    if tried.explained is not None:
        costly = [effect for effect in costly if _feigned(effect, tried.explained, predictor.system)]
    tried.look(costly, part(progress, share, 1.0))
    tried.look_simpler({kind_and_place(effect) for effect in suspects.effects})
    return ranked_by_bic(tried.fits)


class _Round:
    """Suspects beside accepted effects: looked at all, the best of them fitted."""

    def __init__(self, predictor: Predictor, accepted: tuple[Effect, ...]) -> None:
        self._predictor, self._accepted = predictor, accepted
        self._glimpses = predictor.coarse_prediction(accepted)
        self._near: dict[tuple[str, str], tuple[float, Effect]] = {}
        self._fitted: set[tuple[str, str]] = set()
        self._hopeless = np.inf  # cost on a first look
        self.fits: list[Fit] = []
        self.explained: Effect | None = None  # that which leaves noise alone, and least on a first look

    def look(self, suspects: Sequence[Effect], progress: Progress) -> None:
        """Look at suspects, and fit those that are among the best so far."""
        if not suspects:
            return
        starts = scan(self._glimpses, self._accepted, suspects, part(progress, 0.0, 0.5))
        for i, start in enumerate(starts):
            progress(0.5 + 0.25 * i / len(starts), f"approaching {start.effect.kind}")
            with suppress(InvalidInputError):  # what cannot be predicted cannot be what was measured
                effect, cost = coarse_fit(self._glimpses, self._accepted, start.effect, start.widening)
                name = kind_and_place(effect)
                if name not in self._near or cost < self._near[name][0]:
                    self._near[name] = (cost, effect)
        best = _worth_fitting(self._near.values())
        for i, (cost, effect) in enumerate(best):
            progress(0.75 + 0.25 * i / len(best), f"fitting {effect.kind}")
            self._fit(cost, effect)

    def look_simpler(self, suspected: set[tuple[str, str]]) -> None:
        """Fit what the best would be without its one number more, which may not have been among the best."""
        best = min(self.fits, key=lambda one: one.bic, default=None)
        simpler = None if best is None else best.effects[-1].reduced_model()
        if simpler is not None and kind_and_place(simpler[0]) in suspected - self._fitted:
            with suppress(InvalidInputError):
                self.fits.append(fit(self._predictor, (*self._accepted, simpler[0])))

    def _fit(self, cost: float, effect: Effect) -> None:
        hopeless = cost > self._hopeless and (len(self.fits) >= SHOWN or effect.intermittent)
        given_up = self._predictor.budget.exhausted and len(self.fits) > 0
        if hopeless or given_up or kind_and_place(effect) in self._fitted:
            return
        self._fitted.add(kind_and_place(effect))
        with suppress(InvalidInputError):
            found = fit(self._predictor, (*self._accepted, effect))
            self.fits.append(found)
            if HOPELESS * cost < self._hopeless and self._explains(found):
                self._hopeless, self.explained = HOPELESS * cost, effect

    def _explains(self, found: Fit) -> bool:
        # Gaps cost more than a fit where power leaks, and only those of fits that are nearly right matter.
        near = found.chi_square < FIT.near_noise * found.n_data
        return near and is_noise_only(self._predictor, found.residual)


def _feigned(force: Effect, explained: Effect, system: DynamicSystem) -> bool:
    """Return whether what leaves noise alone could be the straight line of a nonlinear force at a DoF.

    Where it acts, or at the end of a member that is blamed; of all members, but never of a channel.
    """
    if not explained.structural or not isinstance(force.at, Dof):
        return explained.structural
    if isinstance(explained.at, Dof):
        return explained.at == force.at
    if isinstance(explained.at, Members) and system.members is not None:
        ends = zip(system.members.numbers, system.members.ends, strict=True)
        return any(force.at.node in pair for number, pair in ends if number in explained.at.numbers)
    return True


def _worth_fitting(near: Iterable[tuple[float, Effect]]) -> list[tuple[float, Effect]]:
    """Return the effects that left least on first looks, and what: the best places of several kinds."""
    chosen: list[tuple[float, Effect]] = []
    for cost, effect in sorted(near, key=lambda pair: pair[0]):
        alike = sum(one.kind == effect.kind for _, one in chosen)
        if len(chosen) < FITTED and alike < PLACES_FITTED:
            chosen.append((cost, effect))
    return chosen
