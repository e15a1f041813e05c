"""The one way to a diagnosis: a model, a measurement with its log book, nothing else."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.progress import Progress, silent
from modallab.diagnosis.evidence import gather, locate
from modallab.diagnosis.fitting import Fit
from modallab.diagnosis.observed import Observed, observe
from modallab.diagnosis.predictor import Predictor, check_comparable
from modallab.diagnosis.residual import scatter
from modallab.diagnosis.result import (
    Alias,
    Curves,
    Diagnosis,
    FittedEffect,
    FittedParameter,
    NextTest,
    Rival,
    Step,
    Verdict,
)
from modallab.diagnosis.search import (
    ALIKE,
    Accepted,
    Path,
    Suspects,
    only_noise_left,
    probabilities,
    search,
    temperature,
)
from modallab.fe.structure import Structure
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup

FEW = 4  # FRFs below which lines are held out instead of FRFs
MOST_ALIKE = 3
RULED_OUT = 0.01  # suspicion below which a kind is not looked for unless it is named


def diagnose(
    structure: Structure,
    measurement: Measurement,
    *,
    suspects: Sequence[str] | None = None,
    hold_out_fraction: float = 0.25,
    hold_out: Sequence[Dof] = (),
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
    seed
        Draws the FRFs that are held out.

    Raises
    ------
    InvalidInputError
        If the measurement cannot be weighed or compared, or no suspect is left.
    UnknownDofError
        If the model lacks a measured DoF.
    """
    check_comparable(structure, measurement)
    held, unmeasured = _held_out(structure, measurement, hold_out_fraction, hold_out, seed)
    observed = observe(measurement, held, fraction=hold_out_fraction)
    predictor = Predictor(structure, measurement.setup, observed)
    evidence = gather(predictor, [])
    candidates = Suspects(suspected(predictor, suspects), RULED_OUT if suspects is None else 0.0)
    path = search(predictor, candidates, max_effects=max_effects, progress=progress)
    progress(0.97, "writing down what was found")
    steps = tuple(_step(predictor, accepted, path.fit) for accepted in path.steps)
    verdict = _verdict(predictor, path, steps)
    extended, log_book = _with(structure, measurement.setup, path.fit.effects)
    start, left = path.start.residual, path.fit.residual
    return Diagnosis(
        verdict=verdict,
        located=locate(evidence),
        steps=steps,
        remaining_gap=left.gap(observed.usable),
        remaining_scatter=scatter(observed, left, observed.usable),
        gaps={"before": start.gaps(observed.usable), "after": left.gaps(observed.usable)},
        structure=extended,
        setup=log_book,
        curves=_curves(predictor, measurement, path.fit, unmeasured),
        candidates=_rivals(predictor, path.steps[0].tried, skip=0) if path.steps else (),
        next_test=_next_test(steps) if verdict is Verdict.AMBIGUOUS else None,
        seed=seed,
    )


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


def _held_out(
    structure: Structure, measurement: Measurement, fraction: float, named: Sequence[Dof], seed: int
) -> tuple[list[Dof], tuple[Dof, ...]]:
    """Return the measured responses to hold out, and the unmeasured ones to predict."""
    if not 0 <= fraction <= 0.5:
        raise InvalidInputError(
            "at most half of the FRFs can be held out",
            field="hold_out.fraction",
            value=fraction,
            allowed="0 to 0.5",
        )
    outputs = {dof.point: dof for dof in measurement.frf.outputs}
    for dof in named:
        structure.index(dof)
    held = [outputs[dof.point] for dof in named if dof.point in outputs]
    unmeasured = tuple(dof for dof in named if dof.point not in outputs)
    # The drive point stays in the fit: it alone ties the FRFs to the force.
    free = [d for d in outputs.values() if d not in held and d.point != measurement.setup.drive.point]
    wanted = int(fraction * len(outputs)) - len(held)
    if len(outputs) >= FEW and wanted > 0:
        drawn = np.random.default_rng(seed).choice(len(free), size=min(wanted, len(free)), replace=False)
        held += [free[i] for i in sorted(drawn)]
    return held, unmeasured


def _fitted(fit: Fit, i: int) -> FittedEffect:
    effect, errors = fit.effects[i], fit.errors[i]
    numbers = {
        name: FittedParameter(effect.parameters[name], errors[name], spec.unit)
        for name, spec in effect.specs().items()
    }
    return FittedEffect(effect.kind, effect.at, numbers)


def _rivals(predictor: Predictor, tried: Sequence[Fit], *, skip: int) -> tuple[Rival, ...]:
    where = predictor.observed.fitted
    shares = probabilities(predictor, tried)
    return tuple(
        Rival(f.effects[-1].kind, f.effects[-1].at, share, f.residual.gap(where))
        for f, share in list(zip(tried, shares, strict=True))[skip:]
    )


def _step(predictor: Predictor, accepted: Accepted, final: Fit) -> Step:
    observed, tried = predictor.observed, accepted.tried
    near = ALIKE * temperature(predictor, tried[0])
    chosen = next(f for f in tried if (f.effects[-1].kind, str(f.effects[-1].at)) == accepted.kind_and_place)
    alike = [f for f in tried if f is not chosen and abs(f.chi_square - chosen.chi_square) < near]
    shares = dict(zip(map(id, tried), probabilities(predictor, tried), strict=True))
    # Sizes from the last fit: what was missing beside an effect still distorts its own round's.
    position = [(e.kind, str(e.at)) for e in final.effects].index(accepted.kind_and_place)
    return Step(
        effect=_fitted(final, position),
        probability=shares[id(chosen)],
        gap_before=accepted.before.residual.gap(observed.fitted),
        gap_after=accepted.after.residual.gap(observed.fitted),
        held_out_gap_before=accepted.before.residual.gap(observed.kept),
        held_out_gap_after=accepted.after.residual.gap(observed.kept),
        held_out_scatter=scatter(observed, accepted.after.residual, observed.kept),
        rivals=_rivals(predictor, tried, skip=1),
        rivals_alike=tuple(Alias(f.effects[-1].kind, f.effects[-1].at) for f in alike[:MOST_ALIKE]),
    )


def _verdict(predictor: Predictor, path: Path, steps: Sequence[Step]) -> Verdict:
    if not only_noise_left(predictor, path.fit.residual):
        return Verdict.UNEXPLAINED
    if not steps:
        return Verdict.NOTHING_MISSING
    return Verdict.AMBIGUOUS if any(step.rivals_alike for step in steps) else Verdict.EXPLAINED


def _with(structure: Structure, setup: RigSetup, effects: Sequence[Effect]) -> tuple[Structure, RigSetup]:
    """Return model and log book with what was added."""
    for effect in effects:
        if effect.structural:
            structure = effect.added_to(structure)
        else:
            setup = replace(setup, effects=(*setup.effects, effect.spec))
    return structure, setup


def _next_test(steps: Sequence[Step]) -> NextTest:
    """Return the measurement that would tell the first ambiguous step from what looks like it."""
    step = next(s for s in steps if s.rivals_alike)
    names = (step.effect.kind, *(alias.kind for alias in step.rivals_alike))
    sides = {EFFECTS[name].structural for name in names}
    if len(sides) == 2:
        return NextTest(
            "what belongs to the rig moves with the drive point, what belongs to the structure stays",
            {"drive": "another DoF"},
            names,
        )
    return NextTest("a smaller random error tells near places apart", {"averages_factor": 10.0}, names)


def _curves(predictor: Predictor, measurement: Measurement, best: Fit, unmeasured: tuple[Dof, ...]) -> Curves:
    observed: Observed = predictor.observed
    predicted = predictor.unmeasured(best.effects, unmeasured) if unmeasured else None
    return Curves(
        freq=observed.freq,
        measured=observed.h[..., None],
        before=predictor.predict(()).h[..., None],
        after=predictor.predict(best.effects).h[..., None],
        random_error=observed.error[..., None],
        held_out=observed.held_out,
        outputs=measurement.frf.outputs,
        inputs=measurement.frf.inputs,
        predicted=predicted,
        predicted_outputs=unmeasured,
    )
