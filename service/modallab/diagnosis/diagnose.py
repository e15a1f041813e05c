"""The one way to a diagnosis: a model, a measurement with its log book, nothing else."""

from collections.abc import Sequence
from dataclasses import replace

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.progress import Progress, Pulse, part, silent
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.localisation.evidence import collect_evidence
from modallab.diagnosis.localisation.locate import locate
from modallab.diagnosis.optimisation.tolerances import NO_TOLERANCES, Tolerances, nuisance_parameters
from modallab.diagnosis.predicting.held_out import outlying_responses, select_held_out
from modallab.diagnosis.predicting.joint_prediction import FollowUp, FollowUpPredictor, JointPredictor
from modallab.diagnosis.predicting.limitations import limitations
from modallab.diagnosis.predicting.prediction_budget import ENOUGH, PredictionBudget
from modallab.diagnosis.predicting.predictor import Predictor, check_comparable
from modallab.diagnosis.residuals.observed import observe
from modallab.diagnosis.residuals.residual import gap_error
from modallab.diagnosis.result import Diagnosis, Step, Verdict
from modallab.diagnosis.result_builder import curves, extended, rivals, step, tolerated
from modallab.diagnosis.searching.acceptance import is_noise_only
from modallab.diagnosis.searching.search import search
from modallab.diagnosis.searching.search_round import Suspects
from modallab.diagnosis.test_design.proposal import next_test
from modallab.fe.structure import Structure
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup

RULED_OUT = 0.01  # suspicion below which a kind is not looked for unless it is named


def diagnose(
    structure: Structure,
    measurement: Measurement,
    *,
    suspects: Sequence[str] | None = None,
    hold_out_fraction: float = 0.25,
    hold_out: Sequence[Dof] = (),
    tolerances: Tolerances = NO_TOLERANCES,
    follow_ups: Sequence[FollowUp] = (),
    max_effects: int = 4,
    seed: int = 0,
    progress: Progress = silent,
) -> Diagnosis:
    """Return where model and measurement part, what was missing, and what is left.

    The measurement is predicted exactly as its log book says; the truth behind it is not known here.

    Parameters
    ----------
    structure
        The model.
    suspects
        Kinds of effects to consider; None for all.
    hold_out_fraction, hold_out
        Share of the FRFs that is kept out of every fit, and responses that are kept out in any case;
        a response that was not measured is predicted.
    tolerances
        What may differ a little and is no missing effect: fitted with everything else, within limits.
    follow_ups
        Further tests of the same structure, explained together with the first by the same effects.
    seed
        Draws the FRFs that are held out.

    Raises
    ------
    InvalidInputError
        If a measurement cannot be weighed or compared, contradicts what is said to have been changed
        for it, or no suspect is left.
    UnknownDofError
        If the model lacks a measured DoF.
    """
    further = [one.with_consistent_log_book(measurement) for one in follow_ups]
    for test in (measurement, *further):
        check_comparable(structure, test)
    held, unmeasured = select_held_out(structure, measurement, hold_out_fraction, hold_out, seed)
    pulse = Pulse(progress)
    pulse(0.0, "predicting what the model and the log book say")
    tests = [measurement, *further]
    predictor = _predicting(structure, tests, held, hold_out_fraction, tolerances, pulse)
    start = fit(predictor, ())
    # What is tolerated of every channel hides until now that something is wrong with one.
    spared = outlying_responses(predictor.observed, start.residual) if tolerances != NO_TOLERANCES else ()
    if {dof.point for dof in spared} & ({dof.point for dof in held} - {dof.point for dof in hold_out}):
        held, _ = select_held_out(structure, measurement, hold_out_fraction, hold_out, seed, spared=spared)
        predictor = _predicting(structure, tests, held, hold_out_fraction, tolerances, pulse)
        start = fit(predictor, ())
    observed = predictor.observed
    evidence = collect_evidence(predictor.tests[0], [])
    candidates = Suspects(suspected(predictor, suspects), RULED_OUT if suspects is None else 0.0)
    path = search(predictor, start, candidates, max_effects=max_effects, progress=pulse)
    pulse(0.94, "writing down what was found")
    explained = is_noise_only(predictor, path.fit.residual, reach=None)
    steps = tuple(step(predictor, accepted, path.fit, explained=explained) for accepted in path.steps)
    verdict = _verdict(explained, steps)
    model, log_book = extended(structure, measurement.setup, path.fit.effects)
    left = path.fit.residual
    return Diagnosis(
        verdict=verdict,
        located=locate(predictor, evidence),
        steps=steps,
        remaining_gap=left.gap(observed.usable),
        remaining_scatter=gap_error(observed, left, observed.usable),
        gaps={"before": start.residual.gaps(observed.usable), "after": left.gaps(observed.usable)},
        structure=model,
        setup=log_book,
        curves=curves(predictor, measurement, path.fit, unmeasured),
        candidates=rivals(predictor, path.steps[0].round_fits) if path.steps else (),
        next_test=next_test(predictor, path, [one.change for one in follow_ups], part(pulse, 0.94, 1.0)),
        tolerated=tolerated(predictor, path.fit),
        follow_ups=tuple(one.change.plain for one in follow_ups),
        seed=seed,
        notes=(*limitations(measurement, predictor.tests[0].observed), *_cut_short(predictor, explained)),
    )


def _cut_short(predictor: Predictor, explained: bool) -> tuple[str, ...]:
    if explained or not predictor.budget.exhausted:
        return ()
    return ("the search for what is left was given up: no few effects of the catalogue came near it",)


def _predicting(
    structure: Structure,
    tests: Sequence[Measurement],
    held: Sequence[Dof],
    fraction: float,
    tolerances: Tolerances,
    pulse: Pulse,
) -> Predictor:
    """Return what predicts all tests, with the numbers of model and rig free within tolerances."""
    seen = [observe(test, held, fraction=fraction) for test in tests]
    first = Predictor(structure, tests[0].setup, seen[0])
    first.heartbeat, first.budget = pulse.beat, PredictionBudget(ENOUGH * len(tests))
    everywhere = _wherever_heard([test.setup for test in tests])
    first = first.with_nuisances(nuisance_parameters(tolerances, first.system, everywhere))
    rest = [FollowUpPredictor(first, test.setup, one) for test, one in zip(tests[1:], seen[1:], strict=True)]
    return JointPredictor([first, *rest]) if rest else first


def _wherever_heard(setups: Sequence[RigSetup]) -> RigSetup:
    """Return the first log book with the responses of all: each has a transducer that may be a little off."""
    heard: dict[Dof, Dof] = {}
    for setup in setups:
        for dof in setup.responses:
            heard.setdefault(dof.point, dof)
    return replace(setups[0], responses=tuple(heard.values()))


def suspected(predictor: Predictor, kinds: Sequence[str] | None) -> list[Effect]:
    """Return one effect for every kind and place that may be missing.

    Parameters
    ----------
    kinds
        None for all but those that only the user can suspect.

    Raises
    ------
    InvalidInputError
        If a kind is unknown or none is left.
    """
    everything = [kind for kind, cls in EFFECTS.items() if cls.suspected]
    chosen = everything if kinds is None else list(dict.fromkeys(kinds))
    found = [
        EFFECTS[kind](at=place)
        for kind in chosen
        for place in EFFECTS[kind].places(predictor.system, predictor.setup)
    ]
    if not found:
        raise InvalidInputError("no suspect is left", field="suspects", allowed=", ".join(EFFECTS))
    return found


def _verdict(explained: bool, steps: Sequence[Step]) -> Verdict:
    if not explained:
        return Verdict.UNEXPLAINED
    if not steps:
        return Verdict.NOTHING_MISSING
    return Verdict.AMBIGUOUS if any(step.rivals_alike for step in steps) else Verdict.EXPLAINED
