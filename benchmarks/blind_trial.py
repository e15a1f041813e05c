"""A blind trial of the diagnosis: hidden effects, sealed truths, a score.

Each case is a measurement by the `sampled` route of a structure and a rig with one hidden effect, or
none. Kind and place are drawn; the effect's size is chosen so that the gap it opens is log-uniform
from 2 to 10,000. The diagnosis sees the measurement with its log book and the model; the scorer alone
knows the truth.

    python -m benchmarks.blind_trial --cases 40 --seed 1
"""

import argparse
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from modallab.core.dof import Dof
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.observed import observe
from modallab.diagnosis.predictor import Predictor
from modallab.diagnosis.residual import residual
from modallab.diagnosis.result import Diagnosis, Step, Verdict
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.structure import Structure
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import chain
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer, Noise
from modallab.rig.measure import Route, measure, measurement_of
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup

GAPS = (2.0, 1e4)
NOISES = (1e-5, 1e-3)
WIDEST = float(np.log(1e5))  # from its believable size that an effect's strength is drawn


@dataclass(frozen=True)
class Case:
    """One sealed case."""

    number: int
    setup: RigSetup
    truth: Effect | None
    gap: float  # that the effect opens in expectation
    seed: int


@dataclass(frozen=True)
class Score:
    """What became of a case."""

    case: Case
    verdict: str
    named: str
    right: bool
    by_alias: bool
    false_alarm: bool
    held_out_closed: bool
    relative_error: float
    seconds: float


def beam() -> Structure:
    """Return the model of all cases."""
    return STRUCTURES["chapter-5-beam"]()


def cases(count: int, seed: int, *, nothing: int = 6, kinds: Sequence[str] = ()) -> list[Case]:
    """Return sealed cases: kinds in turn at a random place, and `nothing` without an effect.

    Parameters
    ----------
    kinds
        All that a diagnosis looks for and this rig can show, if none is given.
    """
    rng = np.random.default_rng(seed)
    kinds = kinds or _shown(_setup(True, rng))
    found: list[Case] = []
    for number in range(count):
        hidden = number < count - nothing
        kind = kinds[number % len(kinds)] if hidden else None
        # Signals that do not repeat leak already: hidden leakage shows with a periodic one only.
        periodic = kind == "leakage" or bool(rng.integers(2))
        setup = _setup(periodic, rng)
        target = _drawn_gap(rng)
        truth, gap = (None, 1.0) if kind is None else _sized(kind, setup, target, rng)
        found.append(Case(number, setup, truth, gap, int(rng.integers(2**31))))
    return found


def _shown(setup: RigSetup) -> list[str]:
    system = assemble(beam())
    return [kind for kind, cls in EFFECTS.items() if cls.suspected and cls.places(system, setup)]


def _setup(periodic: bool, rng: np.random.Generator) -> RigSetup:
    low, high = np.log(NOISES)
    noise = np.exp(rng.uniform(low, high, size=2))
    excitation = ExcitationSetting("periodic_random" if periodic else "random")
    return RigSetup(
        drives=(Dof.parse("1:+Y"),),
        responses=tuple(Dof(n, "Y") for n in range(1, 22, 2)),
        exciter=Exciter(armature_mass=0.02),
        force_transducer=ForceTransducer(mass_below=0.01),
        accelerometers=Accelerometers(mass=0.02, roving=True),
        noise=Noise(float(noise[0]), float(noise[1])),
        analyser=Analyser(window="rectangular" if periodic else "hann", excitation=excitation),
    )


def opened(setup: RigSetup, effect: Effect) -> float:
    """Return the gap that an effect opens in expectation, random error included."""
    spectra = expected_spectra(chain(assemble(beam()), setup, [effect]))
    observed = observe(measurement_of(spectra, setup), (), fraction=0.0)
    left = Predictor(beam(), setup, observed).residual(())
    return 1.0 + replace(left, excess=None).gap(observed.usable)


def _sized(kind: str, setup: RigSetup, target: float, rng: np.random.Generator) -> tuple[Effect, float]:
    """Return an effect at a random place with the gap that it opens: the target, where bounds allow."""
    system = assemble(beam())
    places = EFFECTS[kind].places(system, setup)
    for _ in range(20):
        suspect = EFFECTS[kind](at=places[int(rng.integers(len(places)))])
        sized = _with_gap(suspect, setup, target, more=bool(rng.integers(2)))
        if sized is not None:
            return sized, opened(setup, sized)
        target = _drawn_gap(rng)  # out of this kind's reach: another one
    return suspect, opened(setup, suspect)  # as weak or as strong as it is believable


def _with_gap(suspect: Effect, setup: RigSetup, target: float, *, more: bool) -> Effect | None:
    """Return the suspect as strong as the gap asks for; None if its bounds do not allow it."""
    if not suspect.specs():
        return suspect
    name, spec = next(iter(suspect.specs().items()))
    usual = type(suspect)().parameters[name]

    def effect(strength: float) -> Effect:
        if spec.signed:
            value = (usual if more else -usual) * np.exp(strength)
        elif spec.absent == 1:
            value = np.exp(strength if more else -strength)
        else:
            value = usual * np.exp(strength)
        return suspect.with_parameters({name: float(np.clip(value, spec.lower, spec.upper))})

    def off(strength: float) -> float:
        return float(np.log(opened(setup, effect(strength)) / target))

    low, high = (1e-7, float(np.log(8.0))) if spec.absent == 1 else (-WIDEST, WIDEST)
    if off(low) * off(high) >= 0:
        return None
    return effect(brentq(off, low, high, xtol=1e-3, maxiter=40))


def _drawn_gap(rng: np.random.Generator) -> float:
    return float(np.exp(rng.uniform(*np.log(GAPS))))


def sealed(case: Case) -> Measurement:
    """Return the measurement of a case: arrays and the rig as declared."""
    hidden = [] if case.truth is None else [case.truth]
    rng = np.random.default_rng(case.seed)
    return measure(beam(), case.setup, hidden, route=Route.SAMPLED, rng=rng)


def score(case: Case, found: Diagnosis, measurement: Measurement, seconds: float) -> Score:
    """Return whether the first named effect is the hidden one, or cannot be told from it."""
    first = found.steps[0] if found.steps else None
    right = by_alias = closed = False
    error = np.nan
    if case.truth is not None and first is not None:
        right = (first.effect.kind, first.effect.at) == (case.truth.kind, case.truth.at)
        if not right and len(first.rivals_alike) <= 3:
            by_alias = right = indistinguishable(case, first, measurement)
        last = found.steps[-1]
        closed = last.held_out_gap_after < 1 + 4 * last.held_out_scatter
        if right and not by_alias and case.truth.specs():
            name, spec = next(iter(case.truth.specs().items()))
            true = case.truth.parameters[name]
            error = abs(first.effect.parameters[name].value - true) / abs(true - (spec.absent or 0.0))
    alarm = case.truth is None and found.verdict is not Verdict.NOTHING_MISSING
    if case.truth is None:
        right = not alarm
    named = "nothing" if first is None else f"{first.effect.kind} at {first.effect.at}"
    return Score(case, found.verdict.value, named, right, by_alias, alarm, closed, float(error), seconds)


def indistinguishable(case: Case, step: Step, measurement: Measurement) -> bool:
    """Return whether what was named predicts the same as the truth, within the random error."""
    assert case.truth is not None
    values = {name: p.value for name, p in step.effect.parameters.items()}
    named = EFFECTS[step.effect.kind](at=step.effect.at).with_parameters(values)
    observed = observe(measurement, (), fraction=0.0)
    predictor = Predictor(beam(), case.setup, observed)
    true, other = predictor.predict([case.truth]), predictor.predict([named])
    apart = replace(observed, h=np.where(observed.usable, true.h, 1.0))
    if observed.force is not None:
        apart = replace(apart, force=true.force)
    if observed.incoherent is not None:
        apart = replace(apart, incoherent=true.incoherent)
    return residual(apart, other).gap(observed.usable) < 1.0


def run_case(case: Case) -> Score:
    """Measure, diagnose and score one case."""
    measurement = sealed(case)
    start = time.process_time()
    found = diagnose(beam(), measurement)
    return score(case, found, measurement, time.process_time() - start)


def table(scores: Sequence[Score]) -> str:
    """Return the scores as text."""
    lines = []
    for s in scores:
        truth = "nothing" if s.case.truth is None else f"{s.case.truth.kind} at {s.case.truth.at}"
        mark = "alias" if s.by_alias else "right" if s.right else "WRONG"
        kind = s.case.setup.analyser.excitation.kind
        closed = "held-out closed" if s.held_out_closed else "held-out OPEN"
        lines.append(
            f"{s.case.number:3d} {mark:5s} {kind:16s} gap {s.case.gap:8.1f}  {truth:38s} named {s.named:38s}"
            f" {s.verdict:15s} error {s.relative_error:8.1e} {closed:15s} {s.seconds:5.1f} s"
        )
    hidden = [s for s in scores if s.case.truth is not None]
    right = [s for s in hidden if s.right]
    lines.append(
        f"named first {len(right)} of {len(hidden)} ({100 * len(right) / max(len(hidden), 1):.0f} %), "
        f"{sum(s.by_alias for s in right)} of them by an alias; "
        f"held-out gap back to its scatter in {sum(s.held_out_closed for s in right)} of {len(right)}; "
        f"false alarms {sum(s.false_alarm for s in scores)} of {len(scores) - len(hidden)}; "
        f"median {np.median([s.seconds for s in scores]):.1f} s"
    )
    return "\n".join(lines)


def main() -> None:
    """Run the trial on all cores."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--kinds", nargs="*", default=(), help="of hidden effects; all by default")
    wanted = parser.parse_args()
    drawn = cases(wanted.cases, wanted.seed, kinds=wanted.kinds)
    with ProcessPoolExecutor(wanted.workers) as pool:
        scores = []
        for one in pool.map(run_case, drawn):
            scores.append(one)
            print(table([one]).splitlines()[0], flush=True)
    print(table(scores).splitlines()[-1])


if __name__ == "__main__":
    main()
