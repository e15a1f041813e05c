"""Diagnosis of the disagreement between a model and a measurement with its log book."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import chain

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.line_options import line_mask
from modallab.core.progress import Progress, Pulse, part, silent
from modallab.diagnosis.detection import detection_limits
from modallab.diagnosis.localisation.evidence import collect_evidence
from modallab.diagnosis.localisation.locate import locate
from modallab.diagnosis.measured_tests import MeasuredTests
from modallab.diagnosis.optimisation.tolerances import NO_TOLERANCES, TolerancePreset, Tolerances
from modallab.diagnosis.options import DiagnosisOptions
from modallab.diagnosis.predicting.comparability import check_comparable
from modallab.diagnosis.predicting.follow_up import FollowUp
from modallab.diagnosis.predicting.limitations import limitations
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.predicting.window_in_use import with_window_in_use
from modallab.diagnosis.residuals.residual import gap_error
from modallab.diagnosis.result import Diagnosis, Step, Unknown, Verdict
from modallab.diagnosis.result_builder import curves, extended, rivals, step, tolerated
from modallab.diagnosis.search_result import SearchResult
from modallab.diagnosis.search_task import SearchTask
from modallab.diagnosis.searching.gap_tests import excess_ratio
from modallab.diagnosis.searching.search_path import SearchPath
from modallab.diagnosis.searching.suspects import suspected
from modallab.diagnosis.settings import DIAGNOSIS
from modallab.diagnosis.test_design.proposal import next_test
from modallab.diagnosis.unknown.solve import unknown_effect
from modallab.fe.structure import Structure
from modallab.rig.change import Change
from modallab.rig.measurement import Measurement

# Where a gap remains, the missing effect may be none of the rivals.
INCOMPLETE_PROBABILITY = {
    Verdict.UNEXPLAINED: DIAGNOSIS.incomplete_probability,
    Verdict.PARTLY_EXPLAINED: DIAGNOSIS.partial_probability,
}


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
    declared = [measurement, *(follow_up.with_consistent_log_book(measurement) for follow_up in follow_ups)]
    for test in declared:
        check_comparable(structure, test)
    tests, window_notes = zip(*map(with_window_in_use, declared), strict=True)
    measurement = tests[0]
    measured = MeasuredTests(structure, tests, hold_out_fraction, tuple(hold_out), seed)
    task = SearchTask(measured, suspects, max_effects)
    pulse = Pulse(progress)
    found, assumed = task.run(tolerances, assumed, pulse)
    notes = (*chain.from_iterable(window_notes), *_assumption_note(tolerances, assumed))
    changes = [follow_up.change for follow_up in follow_ups]
    pulse(0.94, "preparing the result")
    result = _result(structure, measurement, found, changes, notes, seed, part(pulse, 0.94, 0.97))
    if found.unexplained_parts:
        return result
    possible = suspected(found.predictor, suspects)
    limits = detection_limits(found.predictor, found.path.fit, possible, part(pulse, 0.97, 1.0))
    return replace(result, detection_limits=limits)


def _result(
    structure: Structure,
    measurement: Measurement,
    found: SearchResult,
    changes: Sequence[Change],
    assumption_notes: tuple[str, ...],
    seed: int,
    progress: Progress,
) -> Diagnosis:
    """Return the diagnosis from the result of a search."""
    predictor, path, explained = found.predictor, found.path, not found.unexplained_parts
    observed, start = predictor.observed, path.start
    verdict, steps = _verdict_and_steps(predictor, path, explained)
    unknown = _unknown(found)
    if unknown is not None and verdict is Verdict.PARTLY_EXPLAINED and _imitated(steps, unknown):
        share = INCOMPLETE_PROBABILITY[Verdict.UNEXPLAINED] / INCOMPLETE_PROBABILITY[verdict]
        verdict = Verdict.UNEXPLAINED
        steps = tuple(replace(each, probability=share * each.probability) for each in steps)
    model, log_book = extended(structure, measurement.setup, path.fit.effects)
    residual = path.fit.residual
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
        unknown=unknown,
        next_test=next_test(predictor, path, changes, progress),
        tolerated=tolerated(predictor, path.fit),
        follow_ups=tuple(change.plain for change in changes),
        seed=seed,
        notes=(
            *limitations(measurement, predictor.tests[0].observed),
            *assumption_notes,
            *_budget_note(predictor, explained),
        ),
    )


def _unknown(found: SearchResult) -> Unknown | None:
    """Return the effect of no catalogue that closes most of what is left in the FRFs; None without one."""
    if "frf" not in found.unexplained_parts:
        return None
    with suppress(InvalidInputError):
        return unknown_effect(found.predictor, found.path)
    return None


def _imitated(steps: Sequence[Step], unknown: Unknown) -> bool:
    """Return whether the added effects imitate an unknown one that alone leaves far less.

    Effects at the place of the unknown one do not imitate it: they may be a part of it. What acts on all
    channels or on the whole structure has no such place.
    """
    elsewhere = unknown.at is None or all(step.effect.at != unknown.at for step in steps)
    excess = DIAGNOSIS.far_less * (steps[-1].gap_after - 1)
    return elsewhere and not unknown.beside_steps and unknown.gap_after - 1 < excess


def _verdict_and_steps(
    predictor: Predictor, path: SearchPath, explained: bool
) -> tuple[Verdict, tuple[Step, ...]]:
    """Return the verdict, and the steps with probabilities that the verdict scales."""
    steps = tuple(step(predictor, accepted, path.fit) for accepted in path.steps)
    verdict = _verdict(predictor, path, steps, explained)
    factor = INCOMPLETE_PROBABILITY.get(verdict, 1.0)
    return verdict, tuple(replace(each, probability=factor * each.probability) for each in steps)


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
        "No effect explains the measurement with the stated tolerances alone. "
        f"Tolerances that were not stated are assumed to be ordinary, one standard deviation each: {listed}",
    )


def _budget_note(predictor: Predictor, explained: bool) -> tuple[str, ...]:
    """Return a note if the search ended because its budget of predictions was used up."""
    if explained or not predictor.budget.exhausted:
        return ()
    return (
        "The search was given up: its budget of predictions is used up, and no combination of a few effects "
        "of the catalogue explains the measurement",
    )


def _verdict(predictor: Predictor, path: SearchPath, steps: Sequence[Step], explained: bool) -> Verdict:
    """Return the verdict; partly explained if one effect that surpasses its rivals closes most of the gap.

    Several together can imitate one that no catalogue holds.
    """
    if not steps:
        return Verdict.NOTHING_MISSING if explained else Verdict.UNEXPLAINED
    if explained:
        alike = any(step.rivals_alike for step in steps)
        return Verdict.AMBIGUOUS if alike else Verdict.EXPLAINED
    most = excess_ratio(path.start, path.steps[0].fit, predictor.observed.fitted) <= DIAGNOSIS.partial_excess
    return Verdict.PARTLY_EXPLAINED if most and not steps[0].rivals_alike else Verdict.UNEXPLAINED
