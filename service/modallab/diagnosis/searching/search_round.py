"""One round of the search: every suspect beside the accepted effects, the best candidates fitted."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress

import numpy as np

from modallab.core.errors import InvalidInputError
from modallab.core.progress import Progress, part, silent
from modallab.diagnosis.fitting.coarse_fit import coarse_fit
from modallab.diagnosis.fitting.fit import Fit, fit, with_optional_parameters
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import ranked_by_bic
from modallab.diagnosis.searching.equivalent_places import next_equivalent
from modallab.diagnosis.searching.exciter_resonance import with_resonance_at_lines
from modallab.diagnosis.searching.gap_tests import has_no_lack_of_fit
from modallab.diagnosis.searching.imitation import is_imitated
from modallab.diagnosis.searching.limiting_fits import with_limiting_effects, with_reduced_model
from modallab.diagnosis.searching.narrower_errors import with_narrower_errors
from modallab.diagnosis.searching.neighbouring_places import neighbouring_effects, similar_effects
from modallab.diagnosis.searching.restarted_fits import fitted_from_explanation, with_best_from_base
from modallab.diagnosis.searching.round_settings import ROUND
from modallab.diagnosis.searching.scan_settings import LOSS
from modallab.diagnosis.searching.scanning import StartingPoint, scan
from modallab.diagnosis.searching.search_path import kind_and_place
from modallab.diagnosis.searching.single_lines import visible_at_single_lines
from modallab.diagnosis.searching.suspects import Suspects
from modallab.rig.effect import EFFECTS, Effect


def fit_candidates(
    predictor: Predictor,
    base: Fit,
    suspects: Suspects,
    *,
    progress: Progress,
    explains: Callable[[Fit], bool] | None = None,
    explanation: Fit | None = None,
    chi_square_without: float = np.inf,
) -> list[Fit]:
    """Return fits of the accepted effects with one suspect added, best first, one per kind and place.

    Parameters
    ----------
    explains
        Whether a fit leaves random error alone beside what this predictor does not know, as tolerances that
        are assumed later; None: what leaves random error alone for this predictor.
    explanation
        Fit of the accepted effects and one suspect that leaves random error alone, if there is one: of the
        others those are fitted that may come as near.
    chi_square_without
        Chi-square that tolerances assumed later leave without any effect. Nonlinear forces, whose predictions
        cost most, are left to a search beside these if no linear effect comes as near the data.
    """
    predictor = predictor.with_nuisances_at(base.starting_position)
    likely = suspects.of(predictor, base.effects)
    linear = [effect for effect in likely if effect.on_motion() is None]
    nonlinear = [effect for effect in likely if effect.on_motion() is not None]
    share = ROUND.linear_share if nonlinear else 1.0
    suspected = {kind_and_place(effect) for effect in suspects.effects}
    candidates = _Round(predictor, base, suspected)
    if explanation is not None:
        candidates.add_explanation(explanation)
    candidates.fit_at_single_lines(linear)
    candidates.examine(linear, part(progress, 0.0, share))
    if explains is not None and nonlinear:
        candidates.accept_best(explains)
    if candidates.explanation is not None:
        linear_effect, system = candidates.explanation, predictor.system
        nonlinear = [effect for effect in nonlinear if is_imitated(effect, linear_effect, system)]
        nonlinear = candidates.rivals_among(nonlinear)
    elif min((single.chi_square for single in candidates.fits), default=np.inf) > chi_square_without:
        nonlinear = []
    candidates.examine(nonlinear, part(progress, share, 1.0))
    candidates.fit_rivals_from_explanation()
    candidates.fit_limits_of_best()
    return ranked_by_bic(candidates.fits)


class _Round:
    """Suspects beside accepted effects: all scanned, the best of them fitted."""

    def __init__(self, predictor: Predictor, base: Fit, suspected: set[tuple[str, str]]) -> None:
        self._predictor, self._base, self._suspected = predictor, base, suspected
        self._accepted = base.effects
        self._coarse = predictor.coarse_prediction(base.effects)
        self._candidates: dict[tuple[str, str], tuple[float, Effect]] = {}
        self._fitted: set[tuple[str, str]] = set()
        self._max_cost = np.inf  # of a coarse fit
        self._budget_limit = np.inf  # predictions spent when no further fit begins
        self._from_declared: set[tuple[str, str]] = set()
        self._repeated: set[tuple[str, str]] = set()  # whose fits from declared values ended alike
        self.fits: list[Fit] = []
        self.explanation: Effect | None = None  # leaves only noise, at the least cost of a coarse fit

    def examine(self, suspects: Sequence[Effect], progress: Progress) -> None:
        """Scan suspects, and fit those that are among the best so far."""
        if not suspects:
            return
        starts = scan(self._coarse, self._accepted, suspects, part(progress, 0.0, 0.5))
        for effect, cost in self._approached(starts, part(progress, 0.5, 0.75)):
            name = kind_and_place(effect)
            if name not in self._candidates or cost < self._candidates[name][0]:
                self._candidates[name] = (cost, effect)
        best = _worth_fitting(self._candidates.values())
        budget = self._predictor.budget
        self._budget_limit = budget.spent + ROUND.budget_share * budget.remaining
        for i, (cost, effect) in enumerate(best):
            progress(0.75 + 0.25 * i / len(best), f"fitting {effect.kind}")
            enough = len(self.fits) >= ROUND.min_fits
            hopeless = cost > self._max_cost and (enough or effect.intermittent)
            hopeless |= enough and not self._is_competitive(cost)
            given_up = self._is_budget_spent and len(self.fits) > 0
            if not hopeless and not given_up:
                self._fit(cost, effect)
        self._fit_from_declared()
        self._fit_neighbours()
        self._fit_from_declared()
        self._fit_similar_kinds()

    def fit_at_single_lines(self, suspects: Sequence[Effect]) -> None:
        """Fit what single lines show, which coarse predictions may leave out."""
        for effect in visible_at_single_lines(self._predictor, self._base, suspects):
            with suppress(InvalidInputError):
                _, cost = coarse_fit(self._coarse, self._accepted, effect, 0.0)
                self._candidates[kind_and_place(effect)] = (cost, effect)
                self._fit(cost, effect)

    def add_explanation(self, single: Fit) -> None:
        """Add the fit of a suspect that leaves random error alone."""
        effect = single.effects[-1]
        _, cost = coarse_fit(self._coarse, self._accepted, effect, 0.0)
        self._fitted.add(kind_and_place(effect))
        self._candidates[kind_and_place(effect)] = (cost, effect)
        self.fits.append(single)
        self._max_cost, self.explanation = ROUND.hopeless_cost * cost, effect

    def accept_best(self, explains: Callable[[Fit], bool]) -> None:
        """Take the best fit for the explanation if it is one, unless there is one already."""
        if self.explanation is None and self.fits:
            best = min(self.fits, key=Fit.bic_between_kinds)
            if explains(best):
                cost, effect = self._start_of(best)
                self._max_cost, self.explanation = ROUND.hopeless_cost * cost, effect

    def rivals_among(self, forces: Sequence[Effect]) -> list[Effect]:
        """Return the nonlinear forces that may come as near the data as the explanation that was found.

        They change FRFs much like an effect that they are linearised to: those at its best places may. Where
        their motion is measured the spectra tell a force too weak for that, and it is tried beside an
        explanation at its place; one of the whole structure is no such place.
        """
        measured = {channel.response.point for channel in self._predictor.observed.channels}
        everywhere = self.explanation is not None and self.explanation.at is None
        unclear = [f for f in forces if f.linearised_kinds and (everywhere or f.at not in measured)]
        kinds_and_places = dict.fromkeys(
            (kind, force.at) for force in unclear for kind in force.linearised_kinds
        )
        linear = [EFFECTS[kind](at=place) for kind, place in kinds_and_places]
        starts = scan(self._coarse, self._accepted, linear, silent) if linear else []
        approached = self._approached(starts, silent)
        near = {str(effect.at) for effect, cost in approached if cost <= self._max_cost}
        return [force for force in forces if force not in unclear or str(force.at) in near]

    def _approached(
        self, starts: Sequence[StartingPoint], progress: Progress
    ) -> Iterator[tuple[Effect, float]]:
        """Yield the coarse fits from starting points with their costs.

        Where two starts of an effect lead to the same cost, far above another's, a third is not tried; unless
        they differ in a choice, which no fit varies.
        """
        costs: dict[tuple[object, ...], list[float]] = {}
        lowest = np.inf
        for i, start in enumerate(starts):
            progress(i / len(starts), f"approaching {start.effect.kind}")
            known = costs.setdefault((*kind_and_place(start.effect), *_choices(start.effect)), [])
            low, high = (min(known[-2:]), max(known[-2:])) if len(known) > 1 else (0.0, np.inf)
            if low > ROUND.hopeless_cost * lowest and high < (1 + ROUND.same_cost) * low:
                continue
            with suppress(InvalidInputError):  # an effect that cannot be predicted is no explanation
                effect, cost = coarse_fit(self._coarse, self._accepted, start.effect, start.noise_inflation)
                known.append(cost)
                lowest = min(lowest, cost)
                yield effect, cost

    def _fit_neighbours(self) -> None:
        """Fit the best effects of the structure at adjoining places too, on and on while one does as well.

        Coarse predictions may mistake a place for its neighbour: nuisance parameters enter them linearly.
        """
        for kind in self._best_kinds():
            explored: set[tuple[str, str]] = set()
            while (found := next_equivalent(self.fits, kind, explored)) is not None:
                if explored and found.bic >= self._base.bic:  # what changes nothing does as well everywhere
                    break
                explored.add(kind_and_place(found.effects[-1]))
                for effect in neighbouring_effects(found.effects[-1], self._predictor.system):
                    if self._is_budget_spent:
                        return
                    if kind_and_place(effect) in self._suspected - self._fitted:
                        with suppress(InvalidInputError):
                            inflation = LOSS.noise_inflations[1]
                            near, cost = coarse_fit(self._coarse, self._accepted, effect, inflation)
                            if self._is_competitive(cost):
                                self._fit(cost, near)

    def _fit_from_declared(self) -> None:
        """Fit the best effects from the declared values of tolerances too, while none explains the test.

        What tolerances took up of an effect that was missing may lead away from it, unless that is little.
        """
        if not self.fits or self._base.is_near_data:
            return
        limit = ROUND.declared_cost * min(found.chi_square for found in self.fits)
        new = [found for found in self.fits if kind_and_place(found.effects[-1]) not in self._from_declared]
        self._from_declared |= {kind_and_place(found.effects[-1]) for found in new}
        n_in_vain = 0
        for found in sorted(new, key=lambda found: found.chi_square):
            if found.chi_square < limit and n_in_vain < ROUND.declared_starts:
                n_in_vain = 0 if self._fit_one_from_declared(found) else n_in_vain + 1

    def _fit_one_from_declared(self, found: Fit) -> bool:
        """Fit an effect from the declared values too; return whether that is better by more than rounding."""
        predictor, n = self._predictor, len(self._predictor.nuisances)
        if not n or self.explanation is not None or predictor.budget.exhausted:
            return False
        cost, start = self._start_of(found)
        with suppress(InvalidInputError):
            declared = predictor.with_nuisances_at(np.zeros(n))
            other = fit(declared, (*self._accepted, start), approach=True)
            if abs(other.chi_square / found.chi_square - 1) < ROUND.same_cost:
                self._repeated.add(kind_and_place(found.effects[-1]))
            if other.chi_square < found.chi_square:
                self.fits[self.fits.index(found)] = other
                if self._explains(other):
                    self._max_cost, self.explanation = ROUND.hopeless_cost * cost, other.effects[-1]
                return (1 + ROUND.same_cost) * other.chi_square < found.chi_square
        return False

    def _start_of(self, found: Fit) -> tuple[float, Effect]:
        """Return the cost and the effect of the coarse fit that a fit began at; of a neighbour its own."""
        return self._candidates.get(kind_and_place(found.effects[-1]), (np.inf, found.effects[-1]))

    def _fit_similar_kinds(self) -> None:
        """Fit what acts much as the best effect does, where it touches that."""
        if not self.fits:
            return
        predictor, best = self._predictor, min(self.fits, key=Fit.bic_between_kinds)
        similar = [
            effect
            for effect in similar_effects(best.effects[-1], predictor.system, predictor.setup)
            if kind_and_place(effect) in self._suspected - self._fitted
        ]
        starts = scan(self._coarse, self._accepted, similar, silent) if similar else []
        for effect, cost in self._approached(starts, silent):
            if not predictor.budget.exhausted and self._is_competitive(cost):
                self._fit(cost, effect)
        self._fit_from_declared()

    @property
    def _is_budget_spent(self) -> bool:
        """Whether the fits of the round have taken their share: the rest is for further effects."""
        return self._predictor.budget.spent >= self._budget_limit

    def _is_competitive(self, cost: float) -> bool:
        """Return whether the cost of a coarse fit is not far above that of the best one."""
        return cost < ROUND.competitive_cost * min(least for least, _ in self._candidates.values())

    def _best_kinds(self) -> list[str]:
        """Return the kinds of the best fits of effects of the structure."""
        explained = self.explanation is not None
        least = min((found.chi_square for found in self.fits), default=0.0)
        limit = (ROUND.competitive_cost if explained else ROUND.limiting_cost) * least
        near = [found for found in self.fits if found.chi_square <= limit]
        order = [found.effects[-1] for found in sorted(near, key=Fit.bic_between_kinds)]
        # Fits of nonlinear forces cost most: one less probable than an explanation stays where it is.
        likely = [effect for i, effect in enumerate(order) if not (explained and i and effect.on_motion())]
        kinds = dict.fromkeys(effect.kind for effect in likely if effect.structural)
        return list(kinds)[: ROUND.kinds_at_neighbours]

    def fit_rivals_from_explanation(self) -> None:
        """Fit the rivals of an explanation from its tolerances too.

        Near the data parameters act linearly, and every start leads to the same minimum.
        """
        if self.explanation is not None and self.fits and not self._base.is_near_data:
            best = min(self.fits, key=Fit.bic_between_kinds)
            self.fits = fitted_from_explanation(self._predictor, self._accepted, self.fits, best)

    def fit_limits_of_best(self) -> None:
        """Fit what the best effect tends to and its reduced model, which may not have been among the best."""
        predictor, base, suspected = self._predictor, self._base, self._suspected
        best = min(self.fits, key=Fit.bic_between_kinds, default=None)
        if best is not None and kind_and_place(best.effects[-1]) not in self._repeated:
            self.fits = with_best_from_base(predictor, base, self.fits)
        self.fits = with_limiting_effects(predictor, base, self.fits, suspected)
        unfitted = suspected - self._fitted - {kind_and_place(found.effects[-1]) for found in self.fits}
        self.fits = with_reduced_model(predictor, base, self.fits, unfitted)

    def _fit(self, cost: float, effect: Effect) -> None:
        if kind_and_place(effect) in self._fitted:
            return
        self._fitted.add(kind_and_place(effect))
        with suppress(InvalidInputError):
            lowest = min((fitted.chi_square for fitted in self.fits), default=np.inf)
            limit = ROUND.limiting_cost * lowest
            effects = (*self._accepted, effect)
            candidate = fit(self._predictor, effects, near=self._base, max_chi_square=limit)
            candidate = with_narrower_errors(self._predictor, candidate, self._base)
            if candidate.chi_square < ROUND.optional_cost * lowest:
                candidate = with_resonance_at_lines(self._predictor, candidate, self._base)
                candidate = with_optional_parameters(self._predictor, candidate, self._base)
            self.fits.append(candidate)
            if ROUND.hopeless_cost * cost < self._max_cost and self._explains(candidate):
                self._max_cost, self.explanation = ROUND.hopeless_cost * cost, effect

    def _explains(self, candidate: Fit) -> bool:
        # Gaps cost more than a fit where power leaks, and only those of fits near the data matter.
        return candidate.is_near_data and has_no_lack_of_fit(self._predictor, self._base, candidate)


def _choices(effect: Effect) -> list[tuple[str, float]]:
    """Return the parameters that a fit of an effect does not vary, with their values."""
    fitted = {name for name, _, _ in effect.fitted_specs()}
    return [(name, value) for name, value in effect.parameters.items() if name not in fitted]


def _worth_fitting(candidates: Iterable[tuple[float, Effect]]) -> list[tuple[float, Effect]]:
    """Return the effects of least cost with their costs: the best places of several kinds.

    An effect on the whole structure is no place of its kind: it has a share of its own.
    """
    chosen: list[tuple[float, Effect]] = []
    for cost, effect in sorted(candidates, key=lambda pair: pair[0]):
        share = effect.kind, effect.at is None
        of_kind = sum((listed.kind, listed.at is None) == share for _, listed in chosen)
        if len(chosen) < ROUND.max_fits and of_kind < ROUND.max_fits_of_kind:
            chosen.append((cost, effect))
    return chosen
