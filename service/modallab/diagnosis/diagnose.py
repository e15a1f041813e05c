"""Diagnosis of the disagreement between a model and a measurement with its log book."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.line_options import line_mask
from modallab.core.progress import Progress, Pulse, part, silent
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.fitting.settings import FIT
from modallab.diagnosis.localisation.evidence import collect_evidence
from modallab.diagnosis.localisation.locate import locate
from modallab.diagnosis.optimisation.nuisances import nuisance_parameters
from modallab.diagnosis.optimisation.tolerances import NO_TOLERANCES, TolerancePreset, Tolerances
from modallab.diagnosis.options import DiagnosisOptions
from modallab.diagnosis.predicting.comparability import check_comparable
from modallab.diagnosis.predicting.follow_up import FollowUp
from modallab.diagnosis.predicting.held_out import outlying_frfs, select_held_out
from modallab.diagnosis.predicting.joint_prediction import JointPredictor
from modallab.diagnosis.predicting.limitations import limitations
from modallab.diagnosis.predicting.prediction_budget import PredictionBudget
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.predicting.settings import BUDGET
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.frf_selection import FrfSelection
from modallab.diagnosis.residuals.observed import observe
from modallab.diagnosis.residuals.residual import gap_error
from modallab.diagnosis.result import Diagnosis, Verdict
from modallab.diagnosis.result_builder import curves, extended, rivals, step, tolerated
from modallab.diagnosis.searching.acceptance import is_noise_only, unexplained_parts
from modallab.diagnosis.searching.search import search
from modallab.diagnosis.searching.search_path import SearchPath
from modallab.diagnosis.searching.search_round import Suspects
from modallab.diagnosis.settings import DIAGNOSIS
from modallab.diagnosis.test_design.proposal import equivalent_fits, named_fit, next_test
from modallab.fe.damping import UnknownDamping
from modallab.fe.structure import Structure
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup


def diagnose_with_options(
    structure: Structure,
    measurement: Measurement,
    options: DiagnosisOptions,
    *,
    follow_ups: Sequence[FollowUp] = (),
    progress: Progress = silent,
) -> Diagnosis:
    """Return the diagnosis of a model by a measurement, with the options that it was made with.

    Parameters
    ----------
    options
        The option `act` is for whoever can run a further test.
    follow_ups
        Further tests of the same structure.

    Raises
    ------
    InvalidInputError, UnknownDofError
        As `diagnose`.
    """

    def with_stated_error(test: Measurement) -> Measurement:
        lines = line_mask(test.frf.freq, options.bands, options.exclude)
        # A test of this service has ideal values where its log book leaves something out.
        setup = test.setup if test.route is None else test.setup.simulated
        return replace(test.at(lines), noise_floor=options.noise_floor, setup=setup)

    diagnosis = diagnose(
        structure,
        with_stated_error(measurement),
        suspects=options.suspects,
        hold_out_fraction=options.hold_out.fraction,
        hold_out=[Dof.parse(text, field="hold_out.dofs") for text in options.hold_out.dofs],
        tolerances=options.stated_tolerances,
        assumed=_assumed(structure, options.stated_tolerances) if measurement.route is None else None,
        follow_ups=[FollowUp(with_stated_error(test.measurement), test.change) for test in follow_ups],
        max_effects=options.max_effects,
        seed=options.seed,
        progress=progress,
    )
    return replace(diagnosis, request_options=options.request)


def diagnose(
    structure: Structure,
    measurement: Measurement,
    *,
    suspects: Sequence[str] | None = None,
    hold_out_fraction: float = 0.25,
    hold_out: Sequence[Dof] = (),
    tolerances: Tolerances = NO_TOLERANCES,
    assumed: Tolerances | None = None,
    follow_ups: Sequence[FollowUp] = (),
    max_effects: int = 4,
    seed: int = 0,
    progress: Progress = silent,
) -> Diagnosis:
    """Return the disagreement of model and measurement, the missing effects, and the remaining gap.

    The prediction follows the log book alone; the true state of a simulated rig is not known here.

    Parameters
    ----------
    structure
        The model.
    measurement
        FRFs and spectra with their log book.
    suspects
        Kinds of effects to consider; None for all.
    hold_out_fraction, hold_out
        Fraction of the FRFs that takes no part in any fit, and responses, or points that a roving hammer
        struck, that take no part in any case; FRFs of responses that were not measured are predicted.
    tolerances
        Prior standard deviations of nuisance parameters, fitted together with the missing effects.
    assumed
        Tolerances of a second search, where the first one leaves more than random error in the FRFs; None:
        no second search.
    follow_ups
        Further tests of the same structure, explained together with the first by the same effects.
    max_effects
        Largest number of effects added.
    seed
        Seed of the choice of held-out FRFs.

    Raises
    ------
    InvalidInputError
        If a measurement has no random error or cannot be compared with the model, if it contradicts the
        changes stated for it, or if no suspect is left.
    UnknownDofError
        If the model lacks a measured DoF.
    """
    tests = [measurement, *(follow_up.with_consistent_log_book(measurement) for follow_up in follow_ups)]
    for test in tests:
        check_comparable(structure, test)
    question = _Question(structure, tests, suspects, hold_out_fraction, tuple(hold_out), max_effects, seed)
    found, assumed = question.answered(tolerances, assumed, progress)
    pulse = Pulse(progress)
    pulse(0.94, "preparing the result")
    predictor, path, explained = found.predictor, found.path, not found.unexplained_parts
    observed, start = predictor.observed, path.start
    verdict = _verdict(predictor, path, explained)
    steps = tuple(step(predictor, accepted, path.fit, verdict) for accepted in path.steps)
    model, log_book = extended(structure, measurement.setup, path.fit.effects)
    residual = path.fit.residual
    changes = [follow_up.change for follow_up in follow_ups]
    return Diagnosis(
        verdict=verdict,
        located=locate(predictor, collect_evidence(predictor.tests[0], [])),
        steps=steps,
        remaining_gap=residual.gap(observed.usable),
        remaining_scatter=gap_error(observed, residual, observed.usable),
        gaps={"before": start.residual.gaps(observed.usable), "after": residual.gaps(observed.usable)},
        structure=model,
        setup=log_book,
        curves=curves(predictor, measurement, path.fit, found.unmeasured),
        candidates=rivals(predictor, path.steps[0].round_fits) if path.steps else (),
        next_test=next_test(predictor, path, changes, part(pulse, 0.94, 1.0)),
        tolerated=tolerated(predictor, path.fit),
        follow_ups=tuple(change.plain for change in changes),
        seed=seed,
        notes=(
            *limitations(measurement, predictor.tests[0].observed),
            *_assumption_note(tolerances, assumed),
            *_budget_note(predictor, explained),
        ),
    )


@dataclass(frozen=True, eq=False)
class _Found:
    """End of a search."""

    predictor: Predictor
    path: SearchPath
    unmeasured: tuple[Dof, ...]
    """Held-out responses without a test."""

    @cached_property
    def unexplained_parts(self) -> set[str]:
        """Parts of the measurement whose gap is more than random error."""
        return unexplained_parts(self.predictor, self.path.fit, max_lag=None)


@dataclass(frozen=True, eq=False)
class _Question:
    """What is diagnosed, whatever the tolerances."""

    structure: Structure
    tests: Sequence[Measurement]
    suspects: Sequence[str] | None
    hold_out_fraction: float
    hold_out: tuple[Dof, ...]
    max_effects: int
    seed: int

    def answered(
        self, stated: Tolerances, assumed: Tolerances | None, progress: Progress
    ) -> tuple[_Found, Tolerances | None]:
        """Return the end of the search, and the assumed tolerances if it needed them.

        The stated tolerances come first: a model that is exact loses nothing by those assumed. They are not
        searched further where the assumed ones leave random error alone, beside one effect at most.
        """
        first = self._prepared(stated, progress)
        if assumed is None or is_noise_only(first.predictor, first.path.fit):
            return self._search_from(first, self.max_effects, part(progress, 0.05, 1.0)), None
        second = self._prepared(assumed, part(progress, 0.05, 0.1))
        if is_noise_only(second.predictor, second.path.fit):
            return second, assumed
        found = self._search_from(first, 1, part(progress, 0.1, 0.3))
        if "frf" not in found.unexplained_parts:
            return found, None
        alone = fit(second.predictor, found.path.fit.effects)
        if not is_noise_only(second.predictor, alone) and self.max_effects > 1:
            first.predictor.budget.limit_to(BUDGET.first_search)
            found = self._search_from(first, self.max_effects, part(progress, 0.3, 0.6))
            if "frf" not in found.unexplained_parts:
                return found, None
        return self._search_from(second, self.max_effects, part(progress, 0.6, 1.0)), assumed

    def _prepared(self, tolerances: Tolerances, progress: Progress) -> _Found:
        """Return the fit under tolerances without any effect."""
        pulse = Pulse(progress)
        pulse(0.0, "predicting the tests from model and log book")
        predictor, start, unmeasured = _first_prediction(
            self.structure, self.tests, self.hold_out_fraction, self.hold_out, tolerances, self.seed, pulse
        )
        return _Found(predictor, SearchPath(start), unmeasured)

    def _search_from(self, prepared: _Found, max_effects: int, progress: Progress) -> _Found:
        """Return the end of a search from the fit without any effect."""
        predictor = prepared.predictor
        least_suspicion = DIAGNOSIS.least_suspicion if self.suspects is None else 0.0
        candidates = Suspects(suspected(predictor, self.suspects), least_suspicion)
        path = search(
            predictor, prepared.path.start, candidates, max_effects=max_effects, progress=Pulse(progress)
        )
        return replace(prepared, path=path)


def _assumed(structure: Structure, stated: Tolerances) -> Tolerances | None:
    """Return the tolerances of an uploaded test with the ordinary ones in place of those left out.

    None if none is left out.
    """
    ordinary = Tolerances.preset(TolerancePreset.ORDINARY)
    if not structure.all_members:
        ordinary = replace(ordinary, modulus_variation=None, density_variation=None)
    completed = stated.completed(ordinary)
    return completed if completed != stated.completed(Tolerances.preset(TolerancePreset.NONE)) else None


def _assumption_note(stated: Tolerances, assumed: Tolerances | None) -> tuple[str, ...]:
    """Return a note of the tolerances that were not stated."""
    if assumed is None:
        return ()
    values = {name: value for name, value in assumed.stated.items() if name not in stated.stated}
    listed = ", ".join(f"{name} {value:g}" for name, value in values.items())
    return (
        f"The model with the stated tolerances leaves more than random error, whatever is missing. "
        f"Tolerances that were not stated are assumed to be ordinary, one standard deviation each: {listed}",
    )


def _first_prediction(
    structure: Structure,
    tests: Sequence[Measurement],
    hold_out_fraction: float,
    hold_out: Sequence[Dof],
    tolerances: Tolerances,
    seed: int,
    pulse: Pulse,
) -> tuple[Predictor, Fit, tuple[Dof, ...]]:
    """Return the predictor, its fit without missing effects, and the held-out responses without a test.

    Only with the nuisance parameters fitted do channels with a gross error stand out; these are not held out.
    """
    first = tests[0]
    held_out, unmeasured = select_held_out(structure, first, hold_out_fraction, hold_out, seed)
    predictor = _predictor(structure, tests, held_out, hold_out_fraction, tolerances, pulse)
    start = fit(predictor, ())
    outliers = set[FrfSelection]()
    if any(tolerances.stated.values()):
        frfs = outlying_frfs(predictor.observed, start.residual, roving_hammer=first.setup.roving_hammer)
        outliers = set(frfs)
    named, _ = select_held_out(structure, first, 0.0, hold_out, seed)
    if outliers & (set(held_out) - set(named)):
        held_out, _ = select_held_out(structure, first, hold_out_fraction, hold_out, seed, spared=outliers)
        predictor = _predictor(structure, tests, held_out, hold_out_fraction, tolerances, pulse)
        start = fit(predictor, ())
    return predictor, start, unmeasured


def _budget_note(predictor: Predictor, explained: bool) -> tuple[str, ...]:
    """Return a note if the search ended because its budget of predictions was used up."""
    if explained or not predictor.budget.exhausted:
        return ()
    return (
        "The search was given up: its budget of predictions is used up, and no combination of a few effects "
        "of the catalogue explains the measurement",
    )


def _predictor(
    structure: Structure,
    tests: Sequence[Measurement],
    held_out: Sequence[FrfSelection],
    fraction: float,
    tolerances: Tolerances,
    pulse: Pulse,
) -> Predictor:
    """Return the predictor of all tests, with nuisance parameters free within their tolerances."""
    observations = [observe(test, held_out, fraction=fraction) for test in tests]
    budget = PredictionBudget(BUDGET.predictions_per_test * len(tests))
    first = SingleTestPredictor.of(
        structure, tests[0].setup, observations[0], heartbeat=pulse.beat, budget=budget
    )
    all_responses = _with_all_responses([test.setup for test in tests])
    nuisances = nuisance_parameters(
        tolerances,
        first.system,
        all_responses,
        damping_unknown=isinstance(structure.damping, UnknownDamping),
    )
    first = first.with_nuisances(nuisances)
    for _ in range(FIT.unknown_damping_fits if nuisances.damping_free else 0):
        first = first.with_nuisances_at(fit(first, ()).nuisance_position)
    follow_up_predictors = [
        first.follow_up(test.setup, observed)
        for test, observed in zip(tests[1:], observations[1:], strict=True)
    ]
    return JointPredictor.of([first, *follow_up_predictors]) if follow_up_predictors else first


def _with_all_responses(setups: Sequence[RigSetup]) -> RigSetup:
    """Return the first log book with the responses of all tests: each transducer has nuisances."""
    responses: dict[Dof, Dof] = {}
    for setup in setups:
        for dof in setup.responses:
            responses.setdefault(dof.point, dof)
    return replace(setups[0], responses=tuple(responses.values()))


def suspected(predictor: Predictor, kinds: Sequence[str] | None) -> list[Effect]:
    """Return one effect for each kind and place that may be missing.

    Parameters
    ----------
    kinds
        Kinds of effects; None for all but those that only the user can suspect.

    Raises
    ------
    InvalidInputError
        If a kind is unknown or none is left.
    """
    defaults = [kind for kind, cls in EFFECTS.items() if cls.suspected]
    chosen = defaults if kinds is None else list(dict.fromkeys(kinds))
    free_damping = predictor.nuisances.damping_free
    suspects = [
        EFFECTS[kind](at=place)
        for kind in chosen
        if not (free_damping and EFFECTS[kind].of_stated_damping)
        for place in EFFECTS[kind].places(predictor.system, predictor.setup)
    ]
    if not suspects:
        raise InvalidInputError("no suspect is left", field="suspects", allowed=list(EFFECTS))
    return suspects


def _verdict(predictor: Predictor, path: SearchPath, explained: bool) -> Verdict:
    """Return the verdict; partly explained if the effects surpass their rivals and close most of the gap."""
    if not path.steps:
        return Verdict.NOTHING_MISSING if explained else Verdict.UNEXPLAINED
    alike = any(equivalent_fits(predictor, accepted, named_fit(accepted)) for accepted in path.steps)
    if explained:
        return Verdict.AMBIGUOUS if alike else Verdict.EXPLAINED
    mask = predictor.observed.fitted
    excess, excess_before = (found.residual.gap(mask) - 1 for found in (path.fit, path.start))
    return (
        Verdict.UNEXPLAINED
        if alike or excess > DIAGNOSIS.partial_excess * excess_before
        else Verdict.PARTLY_EXPLAINED
    )
