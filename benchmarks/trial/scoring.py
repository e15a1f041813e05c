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
from modallab.core.place import Channels, Place
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.result import Diagnosis, FittedEffect, Verdict
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.measurement import Measurement

APART = 3.0  # standard deviations of all data together within which two predictions are one
MOST_ALIKE = 3
WITHIN = 1.96  # standard errors: 95 %
FOUR = 4.0  # of its scatter above 1: a gap that counts as closed
CANDIDATES = 8  # that are written down


def score(case: Case, measurement: Measurement, found: Diagnosis | None) -> dict[str, Any]:
    """Return what became of a case, as plain data; without a diagnosis everything is wrong."""
    line: dict[str, Any] = {
        "number": case.number,
        "set": case.set,
        "type": case.type,
        "what": case.what,
        "truth": [_told(effect) for effect in case.truth],
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
    if found is None:
        return line
    return line | _steps(case, found) | _judged(case, found) | _closed(case, measurement, found)


def _told(effect: Effect) -> dict[str, Any]:
    return {"kind": effect.kind, "at": str(effect.at), "parameters": effect.parameters}


def built(named: FittedEffect) -> Effect:
    """Return what was named as an effect."""
    values = {name: one.value for name, one in named.parameters.items()}
    return EFFECTS[named.kind](at=named.at).with_parameters(values)


def same(named: FittedEffect, effect: Effect) -> bool:
    """Return whether kind and place are those of an effect, senses of DoFs apart."""
    return named.kind == effect.kind and _unsigned(named.at) == _unsigned(effect.at)


def _unsigned(place: Place) -> object:
    if isinstance(place, Dof):
        return place.point
    return frozenset(dof.point for dof in place.dofs) if isinstance(place, Channels) else place


def _steps(case: Case, found: Diagnosis) -> dict[str, Any]:
    """Return what was named, each with whether it is true."""
    steps_told = []
    for step in found.steps:
        true = next((effect for effect in case.truth if same(step.effect, effect)), None)
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
        "verdict": found.verdict.value,
        "steps": steps_told,
        "candidates": [
            [f"{r.kind} at {r.at}", r.probability, r.gap_after] for r in found.candidates[:CANDIDATES]
        ],
        "located": list(found.located.words),
        "gaps": {when: dict(parts) for when, parts in found.gaps.items()},
    }


def _errors(named: FittedEffect, true: Effect) -> dict[str, list[float]]:
    """Return errors by parameter.

    Of its true value, of its distance from absent, in its standard errors.
    """
    found = {}
    for name, spec in true.specs().items():
        value, truth = named.parameters[name], true.parameters[name]
        off = value.value - truth
        # What is absent at the far end of a scale is told by its own size.
        far = spec.absent is not None and abs(spec.absent) > 1
        size = truth if spec.absent is None or far else truth - spec.absent
        tiny = 1e-300
        found[name] = [
            abs(off) / max(abs(truth), tiny),
            abs(off) / max(abs(size), tiny),
            off / max(value.standard_error, tiny),
        ]
    return found


def _judged(case: Case, found: Diagnosis) -> dict[str, Any]:
    """Return whether the answer is right, and whether by another name for the same."""
    alone = {
        "nothing": found.verdict is Verdict.NOTHING_MISSING,
        "unknown": found.verdict is Verdict.UNEXPLAINED,
        "log_book": found.verdict is Verdict.UNEXPLAINED,  # where no effect amounts to the mistake
    }
    if case.type == "nothing":
        return {"right": alone["nothing"], "false_alarm": not alone["nothing"]}
    everything = [built(step.effect) for step in found.steps]
    if case.type == "unknown" or not case.truth:
        distance = _apart(case, everything)
        by_alias = not alone[case.type] and distance < _limit(everything)
        return {"right": alone[case.type] or by_alias, "by_alias": by_alias, "apart": distance}
    hits = [any(same(step.effect, effect) for step in found.steps) for effect in case.truth]
    if case.type == "pair":
        named, right = everything, all(hits)
    else:
        named = everything[:1]
        right = bool(found.steps) and same(found.steps[0].effect, case.truth[0])
    result: dict[str, Any] = {"named": hits, "right": right, "extra": len(found.steps) > len(case.truth)}
    if not right and len(named) == len(case.truth):
        few = all(len(step.rivals_alike) <= MOST_ALIKE for step in found.steps[: len(named)])
        distance = _apart(case, named)
        by_alias = few and distance < _limit(named)
        result |= {"right": by_alias, "by_alias": by_alias, "apart": distance}
    return result


def _limit(named: Sequence[Effect]) -> float:
    """Return how far apart two predictions may be; what was fitted is off by its own random error."""
    return float(np.sqrt(APART**2 + sum(len(effect.specs()) for effect in named)))


def _apart(case: Case, named: Sequence[Effect]) -> float:
    """Return how far what was named predicts from the truth, in standard deviations of all data together."""
    gauge = Tolerated(case.bench, tolerant=case.tolerances).gauge
    true = () if case.type == "log_book" else case.truth
    setup = case.setup if case.type == "log_book" else None
    try:
        return gauge.apart(true, named, setup)
    except ModalLabError:  # too much for expected spectra
        return float("inf")


def _closed(case: Case, measurement: Measurement, found: Diagnosis) -> dict[str, Any]:
    """Return how much of the difference from the FRF without random error was closed, and what is left."""
    curves = found.curves
    held: BoolArray = curves.held_out if curves.held_out.any() else np.ones(len(curves.outputs), bool)
    above = measurement.frf.freq > 0
    try:
        true = Predicted.of(spectra_of(case.bench, case.acting, case.setup)).h
    except ModalLabError:
        return {}
    true = true[np.ix_(above, held)]
    n = len(measurement.frf.freq)
    told = [
        curve[:n][np.ix_(above, held)][..., 0] for curve in (curves.before, curves.after, curves.random_error)
    ]
    before, after = (float((np.abs(curve - true) ** 2).sum()) for curve in told[:2])
    noise = float((2 * told[2] ** 2 * np.abs(true) ** 2).sum())
    scatter = found.remaining_scatter
    return {
        "held_out_before": before,
        "held_out_after": after,
        "held_out_noise": noise,
        "remaining_gap": found.remaining_gap,
        "remaining_scatter": scatter,
        "within_scatter": bool(abs(found.remaining_gap - 1) < FOUR * scatter),
    }
