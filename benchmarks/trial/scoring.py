"""What became of a case, told by one who knows the truth."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.trial.cases import Case
from benchmarks.trial.hidden import spectra_of
from benchmarks.trial.tolerated import Tolerated
from modallab.core.arrays import BoolArray
from modallab.core.dof import Dof
from modallab.core.errors import ModalLabError
from modallab.core.place import Channels, Dofs, Place
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.result import Diagnosis, FittedEffect, Verdict
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.measurement import Measurement

INDISTINGUISHABLE = 3.0  # standard deviations of all data together within which two predictions are one
MOST_ALIKE = 3
WITHIN = 1.96  # standard errors: 95 %
FOUR = 4.0  # of its scatter above 1: a gap that counts as closed
CANDIDATES = 8  # that are written down


def score(case: Case, measurement: Measurement, diagnosis: Diagnosis | None) -> dict[str, Any]:
    """Return what became of a case, as plain data; without a diagnosis everything is wrong."""
    line: dict[str, Any] = {
        "number": case.number,
        "set": case.set,
        "type": case.type,
        "what": case.description,
        "truth": [_plain_effect(effect) for effect in case.truth],
        "excluded": list(case.excluded),
        "gap": case.gap,
        "noise": case.bench.setup.noise.response,
        "structure": case.bench.structure.name,
        "roving": case.setup.accelerometers.roving,
        "verdict": "failed",
        "steps": [],
        "right": False,
        "by_alias": False,
    }
    if diagnosis is None:
        return line
    return (
        line | _steps(case, diagnosis) | _judgement(case, diagnosis) | _closed(case, measurement, diagnosis)
    )


def _plain_effect(effect: Effect) -> dict[str, Any]:
    return {"kind": effect.kind, "at": str(effect.at), "parameters": effect.parameters}


def built(effects: FittedEffect) -> Effect:
    """Return what was named as an effect."""
    values = {name: parameter.value for name, parameter in effects.parameters.items()}
    return EFFECTS[effects.kind](at=effects.at).with_parameters(values)


def is_same_effect(effects: FittedEffect, effect: Effect) -> bool:
    """Return whether kind and place are those of an effect, senses of DoFs apart."""
    return effects.kind == effect.kind and _unsigned(effects.at) == _unsigned(effect.at)


def _unsigned(place: Place) -> object:
    if isinstance(place, Dof):
        return place.point
    return frozenset(dof.point for dof in place.dofs) if isinstance(place, Channels | Dofs) else place


def _steps(case: Case, diagnosis: Diagnosis) -> dict[str, Any]:
    """Return what was named, each with whether it is true."""
    steps_told = []
    for step in diagnosis.steps:
        true = next((effect for effect in case.truth if is_same_effect(step.effect, effect)), None)
        steps_told.append(
            {
                "kind": step.effect.kind,
                "at": str(step.effect.at),
                "parameters": {n: [p.value, p.standard_error] for n, p in step.effect.parameters.items()},
                "probability": step.probability,
                "gap_before": step.gap_before,
                "gap_after": step.gap_after,
                "held_out_gap_after": step.held_out_gap_after,
                "held_out_scatter": step.held_out_scatter,
                "rivals_alike": [f"{a.kind} at {a.at}" for a in step.rivals_alike],
                "true": true is not None,
                "errors": {} if true is None else _errors(step.effect, true),
            }
        )
    return {
        "verdict": diagnosis.verdict.value,
        "steps": steps_told,
        "candidates": [
            [f"{r.kind} at {r.at}", r.probability, r.gap_after] for r in diagnosis.candidates[:CANDIDATES]
        ],
        "located": list(diagnosis.located.words),
        "gaps": {when: dict(parts) for when, parts in diagnosis.gaps.items()},
    }


def _errors(effects: FittedEffect, true: Effect) -> dict[str, list[float]]:
    """Return errors by parameter.

    Of its true value, of its distance from absent, in its standard errors.
    """
    diagnosis = {}
    for name, spec in true.specs().items():
        value, truth = effects.parameters[name], true.parameters[name]
        off = value.value - truth
        # What is absent at the far end of a scale is told by its own size.
        far = spec.absent is not None and abs(spec.absent) > 1
        size = truth if spec.absent is None or far else truth - spec.absent
        tiny = 1e-300
        diagnosis[name] = [
            abs(off) / max(abs(truth), tiny),
            abs(off) / max(abs(size), tiny),
            off / max(value.standard_error, tiny),
        ]
    return diagnosis


def _judgement(case: Case, diagnosis: Diagnosis) -> dict[str, Any]:
    """Return whether the answer is right, and whether by another name for the same."""
    single_steps = {
        "nothing": diagnosis.verdict is Verdict.NOTHING_MISSING,
        "unknown": diagnosis.verdict is Verdict.UNEXPLAINED,
        # Where no effect amounts to the mistake; a window is corrected, and a note says so.
        "log_book": diagnosis.verdict is Verdict.UNEXPLAINED
        or any("declares the window" in note for note in diagnosis.notes),
    }
    if case.type == "nothing":
        return {"right": single_steps["nothing"], "false_alarm": not single_steps["nothing"]}
    all_effects = [built(step.effect) for step in diagnosis.steps]
    if case.type == "unknown" or not case.truth:
        distance = _distance(case, all_effects)
        by_alias = not single_steps[case.type] and distance < _limit(all_effects)
        return {"right": single_steps[case.type] or by_alias, "by_alias": by_alias, "apart": distance}
    hits = [any(is_same_effect(step.effect, effect) for step in diagnosis.steps) for effect in case.truth]
    if case.type == "pair":
        effects, right = all_effects, all(hits)
    else:
        effects = all_effects[:1]
        right = bool(diagnosis.steps) and is_same_effect(diagnosis.steps[0].effect, case.truth[0])
    result: dict[str, Any] = {"named": hits, "right": right, "extra": len(diagnosis.steps) > len(case.truth)}
    if not right and len(effects) == len(case.truth):
        few = all(len(step.rivals_alike) <= MOST_ALIKE for step in diagnosis.steps[: len(effects)])
        distance = _distance(case, effects)
        by_alias = few and distance < _limit(effects)
        result |= {"right": by_alias, "by_alias": by_alias, "apart": distance}
    return result


def _limit(effects: Sequence[Effect]) -> float:
    """Return how far apart two predictions may be; what was fitted is off by its own random error."""
    return float(np.sqrt(INDISTINGUISHABLE**2 + sum(len(effect.specs()) for effect in effects)))


def _distance(case: Case, effects: Sequence[Effect]) -> float:
    """Return how far what was named predicts from the truth, in standard deviations of all data together."""
    gauge = Tolerated(case.bench, tolerant=case.tolerances).gauge
    true = () if case.type == "log_book" else case.truth
    setup = case.setup if case.type == "log_book" else None
    try:
        return gauge.distance(true, effects, setup)
    except ModalLabError:  # too much for expected spectra
        return float("inf")


def _closed(case: Case, measurement: Measurement, diagnosis: Diagnosis) -> dict[str, Any]:
    """Return how much of the difference from the FRF without random error was closed, and what is left."""
    curves = diagnosis.curves
    held_out: BoolArray = curves.held_out if curves.held_out.any() else np.ones(len(curves.outputs), bool)
    positive = measurement.frf.freq > 0
    try:
        true = Predicted.of(spectra_of(case.bench, case.acting, case.setup)).h
    except ModalLabError:
        return {}
    true = true[np.ix_(positive, held_out)]
    n = len(measurement.frf.freq)
    predictions = [
        curve[:n][np.ix_(positive, held_out)][..., 0]
        for curve in (curves.before, curves.after, curves.random_error)
    ]
    initial, final = (float((np.abs(curve - true) ** 2).sum()) for curve in predictions[:2])
    noise = float((2 * predictions[2] ** 2 * np.abs(true) ** 2).sum())
    scatter = diagnosis.remaining_scatter
    return {
        "held_out_before": initial,
        "held_out_after": final,
        "held_out_noise": noise,
        "remaining_gap": diagnosis.remaining_gap,
        "remaining_scatter": scatter,
        "within_scatter": bool(abs(diagnosis.remaining_gap - 1) < FOUR * scatter),
    }
