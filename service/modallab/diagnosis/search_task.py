"""Search for missing effects: prediction of the tests, suspects, and stated or assumed tolerances."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from modallab.core.progress import Progress, Pulse, part
from modallab.diagnosis.assumed_tolerances import (
    deviate_far,
    deviates_alone,
    explains_more,
    kinds_and_places,
    may_hide_effects,
    near_data_round,
    refitted_path,
    refitted_round,
)
from modallab.diagnosis.fitting.fit import Fit
from modallab.diagnosis.measured_tests import MeasuredTests, is_far_from_data
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.predicting.settings import BUDGET
from modallab.diagnosis.search_result import SearchResult
from modallab.diagnosis.searching.gap_tests import is_noise_only
from modallab.diagnosis.searching.search import ExplanationCriterion, is_prediction_error, search
from modallab.diagnosis.searching.search_path import SearchPath
from modallab.diagnosis.searching.search_round import fit_candidates
from modallab.diagnosis.searching.settings import SEARCH
from modallab.diagnosis.searching.suspects import Suspects, suspected
from modallab.diagnosis.settings import DIAGNOSIS


@dataclass(frozen=True, eq=False)
class SearchTask:
    """Search for the missing effects of some tests, under any tolerances."""

    tests: MeasuredTests
    """Measurements of the model."""
    suspects: Sequence[str] | None
    """Kinds of effects to consider; None for all."""
    max_effects: int
    """Largest number of effects added."""

    def run(
        self, stated: Tolerances, assumed: Tolerances | None, pulse: Pulse
    ) -> tuple[SearchResult, Tolerances | None]:
        """Return the result of the search, and the assumed tolerances if they were needed.

        It begins anew, once, if effects come near all data but FRFs that were held out; unless the same
        effects explain the measurement with others held out.
        """
        found, tolerances = self._search(stated, assumed, pulse)
        path = found.path
        if not path.steps or not path.fit.is_near_data or not found.unexplained_parts:
            return found, tolerances
        tests = self.tests.sparing_outliers_of(found)
        if tests is None:
            return found, tolerances
        second = tests.fit_without_effects(tolerances or stated, pulse)
        refitted = refitted_path(path, second)
        if refitted is not None:
            return replace(second, path=refitted), tolerances
        return replace(self, tests=tests)._search(stated, assumed, pulse)

    def _search(
        self, stated: Tolerances, assumed: Tolerances | None, pulse: Pulse
    ) -> tuple[SearchResult, Tolerances | None]:
        """Return what `run` does for FRFs that are held out as they are.

        The stated tolerances come first: a model that is exact loses nothing by those assumed.
        """
        pulse(0.0, "predicting the tests from model and log book")
        first = self.tests.fit_without_effects(stated, pulse)
        if assumed is None or is_noise_only(first.predictor, first.path.fit):
            return self._search_from(first, self.max_effects, pulse), None
        found, tolerances = self._search_under_both(first, stated, assumed, pulse)
        if tolerances is not None:
            exact = self._effects_of_exact_model(first, found, stated, part(pulse, 0.75, 1.0))
            if exact is not None:
                return exact, None
        return found, tolerances

    def _effects_of_exact_model(
        self, first: SearchResult, found: SearchResult, stated: Tolerances, progress: Progress
    ) -> SearchResult | None:
        """Return a search that explains the tests under the stated tolerances by up to two effects.

        It is made where the assumed tolerances explain them, beside one effect at most, by deviations so
        improbable that an effect is likelier. None if it is not made, or explains less.

        Parameters
        ----------
        first
            The fit without any effect under the stated tolerances.
        found
            The result under the assumed tolerances.
        """
        if len(found.path.steps) >= SEARCH.pair or self.max_effects < SEARCH.pair:
            return None
        if found.unexplained_parts or not _suggest_effect(found, stated):
            return None
        exact = self._search_from(first, SEARCH.pair, progress)
        return None if exact.unexplained_parts else exact

    def _search_under_both(
        self, first: SearchResult, stated: Tolerances, assumed: Tolerances, pulse: Pulse
    ) -> tuple[SearchResult, Tolerances | None]:
        """Return what `run` does where the stated tolerances alone leave more than random error.

        They are not searched further where the assumed ones leave random error alone, beside one effect at
        most. If the nuisance parameters then deviate far, or one tolerance alone, a single effect that leaves
        random error alone under the stated tolerances is preferred. Where the assumed ones alone come much
        nearer the data the search under them comes first: the model is wrong in many places.
        """
        # Stated tolerances are compared with them; without any, only whether they come near the data counts.
        complete = any(stated.stated.values())
        second = self.tests.fit_without_effects(assumed, pulse, complete=complete)
        nothing_missing = is_noise_only(second.predictor, second.path.fit)
        if nothing_missing and not _suggest_effect(second, stated):
            return self._search_from(second, 1, pulse), assumed
        if not nothing_missing and _come_nearer(first.path.fit, second.path.fit, stated):
            return self._search_beside_assumed(first, second, assumed, pulse)
        # A search for one effect that explains nothing ends before half of its progress.
        single_effects = self._first_round(first, second, part(pulse, 0.05, 0.25))
        found = self._search_from(first, 1, pulse, single_effects)
        if nothing_missing:
            return (second, assumed) if found.unexplained_parts else (found, None)
        if _explains_frfs(found):
            return self._with_spectra_explained(found, single_effects, part(pulse, 0.5, 1.0)), None
        if not complete and is_far_from_data(second.path.fit):
            second = self.tests.fit_without_effects(assumed, pulse)
        return self._search_further(first, second, found, single_effects, assumed, pulse)

    def _search_further(
        self,
        first: SearchResult,
        second: SearchResult,
        found: SearchResult,
        single_effects: Sequence[Fit],
        assumed: Tolerances,
        pulse: Pulse,
    ) -> tuple[SearchResult, Tolerances | None]:
        """Return what `run` does where no single effect leaves random error alone under stated tolerances.

        Where tolerances may hide an effect the search under the assumed ones begins anew. It may miss effects
        that leave random error alone under both: these are then kept.

        Parameters
        ----------
        first, second
            The fits without any effect, under stated and assumed tolerances.
        found
            The best single effect, if any is significant.
        single_effects
            Fits of single effects under the stated tolerances, best first.
        """
        alone = second.with_effects(found.path.fit.effects)
        if not is_noise_only(second.predictor, alone) and self.max_effects > 1:
            budget = first.predictor.budget
            budget.scale_limit(BUDGET.first_search)
            if not budget.exhausted:
                stage = part(pulse, 0.5, 0.75)
                found = self._search_from(first, self.max_effects, stage, single_effects, second.explains)
                if _explains_frfs(found):
                    return found, None
                path = refitted_path(found.path, second)
                if path is not None and not may_hide_effects(found.path, second):
                    return replace(second, path=path), assumed
        refitted = refitted_round(single_effects, second, alone)
        if refitted is None and len(alone.effects) == 1 and is_noise_only(second.predictor, alone):
            refitted = fit_candidates(
                second.predictor,
                second.path.start,
                self._suspects(second.predictor),
                progress=part(pulse, 0.5, 0.75),
                explanation=alone,
            )
        further = self._search_from(second, self.max_effects, part(pulse, 0.75, 1.0), refitted)
        same = kinds_and_places(further.path.fit.effects) == kinds_and_places(found.path.fit.effects)
        path = None if same else refitted_path(found.path, second)
        if path is not None and (further.unexplained_parts or path.fit.bic < further.path.fit.bic):
            return replace(second, path=path), assumed
        if further.unexplained_parts and explains_more(found.path.fit, further.path.fit):
            return found, None
        return further, assumed

    def _with_spectra_explained(
        self, found: SearchResult, single_effects: Sequence[Fit], progress: Progress
    ) -> SearchResult:
        """Return a search for further effects where one explains the FRFs alone, as beside a wrong armature.

        Parameters
        ----------
        found
            The best single effect.
        single_effects
            Fits of single effects under the same tolerances, best first.
        """
        complete = not found.unexplained_parts or is_prediction_error(found.predictor, found.path)
        if complete or self.max_effects == 1:
            return found
        start = replace(found, path=SearchPath(found.path.start))
        return self._search_from(start, self.max_effects, progress, single_effects)

    def _search_beside_assumed(
        self, first: SearchResult, second: SearchResult, assumed: Tolerances, pulse: Pulse
    ) -> tuple[SearchResult, Tolerances | None]:
        """Return what `run` does where the assumed tolerances alone come near the data, not the stated ones.

        A single effect that leaves random error alone under the stated tolerances too is preferred.
        """
        suspects, start = self._suspects(second.predictor), second.path.start
        single_effects = fit_candidates(second.predictor, start, suspects, progress=part(pulse, 0.05, 0.4))
        alone = near_data_round(single_effects, first)
        if alone:
            found = self._search_from(first, 1, part(pulse, 0.4, 0.5), alone)
            if _explains_frfs(found):
                return self._with_spectra_explained(found, alone, part(pulse, 0.5, 1.0)), None
        stage = part(pulse, 0.5, 1.0)
        return self._search_from(second, self.max_effects, stage, single_effects), assumed

    def _first_round(self, start: SearchResult, second: SearchResult, progress: Progress) -> list[Fit]:
        """Return the fits of single effects, best first.

        Parameters
        ----------
        second
            The fit under the assumed tolerances: an effect that leaves random error alone there leaves
            little for a nonlinear force, whose predictions cost most.
        """

        def explains(single: Fit) -> bool:
            return second.explains(single.effects)

        return fit_candidates(
            start.predictor,
            start.path.start,
            self._suspects(start.predictor),
            progress=progress,
            explains=explains,
            chi_square_without=second.path.start.chi_square,
        )

    def _search_from(
        self,
        start: SearchResult,
        max_effects: int,
        progress: Progress,
        first_round: Sequence[Fit] | None = None,
        explains: ExplanationCriterion | None = None,
    ) -> SearchResult:
        """Return the result of a search from the fit without any effect."""
        path = search(
            start.predictor,
            start.path.start,
            self._suspects(start.predictor),
            max_effects=max_effects,
            progress=progress,
            first_round=first_round,
            explains=explains,
        )
        return replace(start, path=path)

    def _suspects(self, predictor: Predictor) -> Suspects:
        least_suspicion = DIAGNOSIS.least_suspicion if self.suspects is None else 0.0
        return Suspects(suspected(predictor, self.suspects), least_suspicion)


def _suggest_effect(under_assumed: SearchResult, stated: Tolerances) -> bool:
    """Return whether deviations within assumed tolerances make an effect likelier."""
    nuisances, found = under_assumed.predictor.nuisances, under_assumed.path.fit
    return deviate_far(nuisances, found, stated) or deviates_alone(nuisances, found, stated)


def _come_nearer(first: Fit, second: Fit, stated: Tolerances) -> bool:
    """Return whether assumed tolerances alone come much nearer the data than the stated ones.

    Without stated tolerances a search is so fast, and an exact model so likely, that only data nearby count.
    """
    if second.is_near_data or not any(stated.stated.values()):
        return second.is_near_data and not first.is_near_data
    return second.chi_square < DIAGNOSIS.much_nearer * first.chi_square


def _explains_frfs(found: SearchResult) -> bool:
    """Return whether random error, or an error of predictions, is all that the effects leave in the FRFs."""
    return "frf" not in found.unexplained_parts or is_prediction_error(found.predictor, found.path)
