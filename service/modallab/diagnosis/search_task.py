"""Search for missing effects: prediction of the tests, suspects, and stated or assumed tolerances."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from modallab.core.dof import Dof
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
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.fitting.settings import FIT
from modallab.diagnosis.fitting.visible_nuisances import with_visible_nuisances
from modallab.diagnosis.optimisation.nuisance_parameters import nuisance_parameters
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.predicting.held_out import outlying_frfs, select_held_out
from modallab.diagnosis.predicting.joint_prediction import JointPredictor
from modallab.diagnosis.predicting.prediction_budget import PredictionBudget
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.predicting.settings import BUDGET
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.frf_selection import FrfSelection
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.search_result import SearchResult
from modallab.diagnosis.searching.acceptance import is_noise_only
from modallab.diagnosis.searching.search import ExplanationCriterion, is_prediction_error, search
from modallab.diagnosis.searching.search_path import SearchPath
from modallab.diagnosis.searching.search_round import fit_candidates
from modallab.diagnosis.searching.settings import ROUND
from modallab.diagnosis.searching.suspects import Suspects, suspected
from modallab.diagnosis.settings import DIAGNOSIS
from modallab.fe.damping import UnknownDamping
from modallab.fe.structure import Structure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.rig.simulated_variance import SimulatedVariance

_FAR_FROM_DATA = ROUND.limiting_cost * FIT.near_noise  # mean square after a few steps


@dataclass(frozen=True, eq=False)
class SearchTask:
    """Search for the missing effects of some tests, under any tolerances."""

    structure: Structure
    """The model."""
    tests: Sequence[Measurement]
    """Measurements of the model."""
    suspects: Sequence[str] | None
    """Kinds of effects to consider; None for all."""
    hold_out_fraction: float
    """Fraction of the FRFs that takes no part in any fit."""
    hold_out: tuple[Dof, ...]
    """Responses that take no part in any case."""
    max_effects: int
    """Largest number of effects added."""
    seed: int
    """Seed of the choice of held-out FRFs."""

    @cached_property
    def _simulated(self) -> tuple[SimulatedVariance, ...]:
        """Variance factors of simulated tests, one cache for each test: tolerances hardly change them."""
        return tuple(SimulatedVariance() for _ in self.tests)

    def run(
        self, stated: Tolerances, assumed: Tolerances | None, pulse: Pulse
    ) -> tuple[SearchResult, Tolerances | None]:
        """Return the result of the search, and the assumed tolerances if they were needed.

        The stated tolerances come first: a model that is exact loses nothing by those assumed. They are not
        searched further where the assumed ones leave random error alone, beside one effect at most. If
        the nuisance parameters then deviate far, or one tolerance alone, a single effect that leaves random
        error alone under the stated tolerances is preferred. Where the assumed ones alone come much nearer
        the data the search under them comes first: the model is wrong in many places.
        """
        pulse(0.0, "predicting the tests from model and log book")
        first = self._start(stated, pulse)
        if assumed is None or is_noise_only(first.predictor, first.path.fit):
            return self._search_from(first, self.max_effects, pulse), None
        # Stated tolerances are compared with them; without any, only whether they come near the data counts.
        complete = any(stated.stated.values())
        second = self._start(assumed, pulse, complete=complete)
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
        if not complete and _is_far_from_data(second.path.fit):
            second = self._start(assumed, pulse)
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

    def _start(self, tolerances: Tolerances, pulse: Pulse, *, complete: bool = True) -> SearchResult:
        """Return the fit under tolerances without any effect.

        Parameters
        ----------
        complete
            Whether it is fitted to its end if a few steps leave it far from the data.
        """
        predictor, unexplained, unmeasured = self._first_prediction(tolerances, pulse, complete=complete)
        return SearchResult(predictor, SearchPath(unexplained), unmeasured)

    def _first_prediction(
        self, tolerances: Tolerances, pulse: Pulse, *, complete: bool
    ) -> tuple[Predictor, Fit, tuple[Dof, ...]]:
        """Return the predictor, its fit without missing effects, and the held-out responses without a test.

        Only with the nuisance parameters fitted do channels with a gross error stand out; these are not held
        out.
        """
        structure, first = self.structure, self.tests[0]
        fraction, dofs = self.hold_out_fraction, self.hold_out
        held_out, unmeasured = select_held_out(structure, first, fraction, dofs, self.seed)
        predictor = self._predictor(held_out, tolerances, pulse)
        start = _without_effects(predictor, complete=complete)
        outliers = set[FrfSelection]()
        if any(tolerances.stated.values()):
            roving_hammer = first.setup.roving_hammer
            outliers = set(outlying_frfs(predictor.observed, start.residual, roving_hammer=roving_hammer))
        of_dofs, _ = select_held_out(structure, first, 0.0, dofs, self.seed)
        if outliers & (set(held_out) - set(of_dofs)):
            held_out, _ = select_held_out(structure, first, fraction, dofs, self.seed, spared=outliers)
            predictor = self._predictor(held_out, tolerances, pulse)
            start = _without_effects(predictor, complete=complete)
        return predictor, start, unmeasured

    def _predictor(self, held_out: Sequence[FrfSelection], tolerances: Tolerances, pulse: Pulse) -> Predictor:
        """Return the predictor of all tests, with nuisance parameters free within their tolerances."""
        structure, tests = self.structure, self.tests
        observations = [observe(test, held_out, fraction=self.hold_out_fraction) for test in tests]
        budget = PredictionBudget(BUDGET.predictions_per_test * len(tests))
        first = SingleTestPredictor.of(
            structure, tests[0].setup, observations[0], heartbeat=pulse.beat, budget=budget
        )
        nuisances = nuisance_parameters(
            tolerances,
            first.system,
            _with_all_responses([test.setup for test in tests]),
            damping_unknown=isinstance(structure.damping, UnknownDamping),
        )
        first = with_visible_nuisances(first.with_nuisances(nuisances))
        budget.scale_limit(1 + len(first.nuisances) / BUDGET.nuisance_parameters)
        for _ in range(FIT.unknown_damping_fits if nuisances.damping_free else 0):
            first = first.with_nuisances_at(fit(first, ()).nuisance_position)
        follow_ups = [
            first.follow_up(test.setup, observed)
            for test, observed in zip(tests[1:], observations[1:], strict=True)
        ]
        predictors = [
            replace(predictor, simulated=simulated)
            for predictor, simulated in zip([first, *follow_ups], self._simulated, strict=True)
        ]
        return JointPredictor.of(predictors) if follow_ups else predictors[0]

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


def _without_effects(predictor: Predictor, *, complete: bool) -> Fit:
    """Return the fit without effects; an incomplete one is given up far from the data after a few steps."""
    if complete:
        return fit(predictor, ())
    observed = predictor.observed
    n_data = len(predictor.residual(()).vector(observed.fitted))
    return fit(predictor, (), max_chi_square=_FAR_FROM_DATA * n_data)


def _is_far_from_data(found: Fit) -> bool:
    """Return whether a fit was given up, if it was not to be complete."""
    return found.chi_square > _FAR_FROM_DATA * found.n_data


def _suggest_effect(second: SearchResult, stated: Tolerances) -> bool:
    """Return whether deviations within assumed tolerances make an effect likelier."""
    nuisances, found = second.predictor.nuisances, second.path.fit
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


def _with_all_responses(setups: Sequence[RigSetup]) -> RigSetup:
    """Return the first log book with the responses of all tests: each transducer has nuisances."""
    responses: dict[Dof, Dof] = {}
    for setup in setups:
        for dof in setup.responses:
            responses.setdefault(dof.point, dof)
    return replace(setups[0], responses=tuple(responses.values()))
