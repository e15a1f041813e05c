"""The diagnosis in a laboratory that is not its own: what is hidden by one simulator, a diagnosis names.

Tests are drawn and measured by `benchmarks.laboratory`, which shares no line with the package: free beams,
cantilevers, portal frames and a fine, lightly damped bar, whose modulus and density are wrong everywhere,
smoothly, by what the presets `careful`, `ordinary` and `student` say; shakers with a roving accelerometer
and roving hammers; noise, level and at times auto spectra that nobody hands over; a band that starts above
0 Hz. In ten tests six hide one effect, two hide two, one none, one an effect of no catalogue. The diagnosis
is given model, log book, FRFs with coherence and the name of the preset.

Right is: the true effect first, or the first one's place or kind listed as alike with it (at most three);
of two both; of none `nothing_missing`; of an unknown one no verdict `explained`. A single effect below the
limit that a `nothing_missing` states does not count, nor a stinger's resonance where FRFs and coherence
alone are handed over: it shapes the force, which is not in them.

    python -m benchmarks.laboratory_trial --count 200 --seed 1 --workers 2 --out laboratory.jsonl
    python -m benchmarks.laboratory_trial --report laboratory.jsonl

Seeds below 1000 are open. Those above are for a closing figure: no code is changed after a look at them.
"""

import json
import time
import traceback
from argparse import Namespace
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bench import Bench, Row, parser
from benchmarks.laboratory.bars import Bars
from benchmarks.laboratory.draws import DrawnTest, drawn
from benchmarks.laboratory.effects import Effect
from benchmarks.laboratory.plan import WINDOW_END, Plan
from benchmarks.laboratory.simulation import Measured, measure
from benchmarks.trial.calibration import calibration
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.place import Channels, Dofs, Members, Place
from modallab.diagnosis.diagnose import diagnose_with_options
from modallab.diagnosis.optimisation.tolerances import TolerancePreset
from modallab.diagnosis.options import DiagnosisOptions
from modallab.diagnosis.result import Diagnosis, Verdict
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Material, Member, Section, Structure, Support
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.hardware import Accelerometers, Exciter, Noise
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup

MOST_ALIKE = 3
LIMITS = {"single": 0.8, "pair": 0.55, "nothing": 0.97}  # least shares that are right
SURE = 0.9
QUICK = 4, 5, 6, 11  # tests of a minute or so, for a figure of a bench


def structure_of(bars: Bars) -> Structure:
    """Return the model as the package describes it: nodes and members count from 1."""
    section = Section(area=bars.area, second_moment=bars.second_moment)
    material = Material(modulus=float(bars.modulus[0]), density=float(bars.density[0]))
    return Structure(
        nodes={i + 1: (float(x), float(y)) for i, (x, y) in enumerate(bars.points)},
        members=tuple(
            Member(i + 1, (int(a) + 1, int(b) + 1), section, material) for i, (a, b) in enumerate(bars.ends)
        ),
        supports=tuple(Support(node + 1, ("X", "Y", "RZ")) for node in bars.clamped),
        damping=StructuralDamping(stiffness_coefficient=bars.loss_factor),
    )


def _log_book(plan: Plan) -> RigSetup:
    kind = "impact" if plan.hammer else "random" if plan.hann else "periodic_random"
    return RigSetup(
        drives=tuple(Dof(node + 1, "Y") for node in plan.driven),
        responses=tuple(Dof(node + 1, "Y") for node in plan.listening),
        exciter=Exciter("hammer" if plan.hammer else "shaker", 0.0 if plan.hammer else plan.armature_mass),
        accelerometers=Accelerometers(mass=plan.accelerometer_mass, roving=not plan.hammer),
        noise=Noise(None, None),
        analyser=Analyser(
            frequency_max=plan.frequency_max,
            frequency_min=float(plan.freq[0]),
            n_lines=len(plan.freq),
            window="exponential" if plan.hammer else "hann" if plan.hann else "rectangular",
            window_end=WINDOW_END,
            averages=plan.averages,
            excitation=ExcitationSetting(kind, level=None, shape="unknown" if plan.hammer else "flat"),
        ),
    )


def measurement_of(plan: Plan, measured: Measured) -> Measurement:
    """Return what is handed over."""
    setup = _log_book(plan)
    frf = FrfSet(
        measured.freq, measured.inertance.astype(complex), setup.responses, setup.drives, FrfKind.INERTANCE
    )
    by_frf = (slice(None), slice(None)) if plan.hammer else (slice(None), slice(None), 0)
    test = Measurement(frf, measured.coherence[by_frf], plan.averages, setup)
    if not plan.spectra:
        return test
    return replace(test, force_spectrum=measured.force, response_spectrum=measured.response[by_frf])


def _is_at(effect: Effect, place: Place, plan: Plan) -> bool:
    """Return whether a place is that of an effect."""
    responses = [effect.at, effect.other] if effect.kind == "swapped_channels" else [effect.at]
    match effect.place:
        case "node":
            true = {effect.at + 1}
        case "bar":
            true = {effect.at + 1}
        case "response":
            true = {plan.listening[i] + 1 for i in responses}
        case _:
            return place is None or (isinstance(place, Dof) and place.node - 1 in plan.driven)
    match place:
        case Dof():
            return {place.node} == true
        case Dofs() | Channels():
            return {dof.node for dof in place.dofs} == true
        case Members():
            return set(place.numbers) == true
    return False


def _is_true(kind: str, place: Place, effect: Effect, plan: Plan) -> bool:
    return kind == effect.kind and _is_at(effect, place, plan)


def score(test: DrawnTest, found: Diagnosis) -> dict[str, Any]:
    """Return what became of a test, as plain data."""
    steps: list[dict[str, Any]] = []
    for step in found.steps:
        named = [(step.effect.kind, step.effect.at)]
        if len(step.rivals_alike) <= MOST_ALIKE:
            named += [(rival.kind, rival.at) for rival in step.rivals_alike]
        true = [
            i
            for i, effect in enumerate(test.hidden)
            if any(_is_true(kind, at, effect, test.plan) for kind, at in named)
        ]
        steps.append(
            {
                "kind": step.effect.kind,
                "at": str(step.effect.at),
                "probability": step.probability,
                "gap_before": step.gap_before,
                "gap_after": step.gap_after,
                "true": bool(true),
                "which": true,
            }
        )
    return {
        "verdict": found.verdict.value,
        "steps": steps,
        "right": _is_right(test, found, steps),
        "visible": not any(_is_invisible(effect, test.plan, found) for effect in test.hidden),
        "remaining_gap": found.remaining_gap,
    }


def _is_right(test: DrawnTest, found: Diagnosis, steps: Sequence[dict[str, Any]]) -> bool:
    match test.type:
        case "nothing":
            return found.verdict is Verdict.NOTHING_MISSING
        case "unknown":
            return found.verdict is not Verdict.EXPLAINED
        case "single":
            return bool(steps) and bool(steps[0]["true"])
    return {i for step in steps for i in step["which"]} == set(range(len(test.hidden)))


def _is_invisible(effect: Effect, plan: Plan, found: Diagnosis) -> bool:
    """Return whether what is handed over cannot show an effect, or is said not to at any place."""
    if effect.kind == "stinger_axial" and not plan.spectra:
        return True
    neutral = 1.0 if effect.kind in ("stiffness_error", "gain_error", "loss_factor_error") else 0.0
    return any(
        limit.kind == effect.kind and abs(effect.size - neutral) < limit.largest
        for limit in found.detection_limits
    )


def run_test(number: int, seed: int, suspects: tuple[str, ...] | None = None) -> dict[str, Any]:
    """Return the score of one test by its number; with few suspects one of little meaning, soon."""
    test = drawn(number, seed)
    measured = measure(
        test.true, test.true_plan, [*test.deviations, *test.hidden], np.random.default_rng(test.seed)
    )
    start = time.process_time()
    line: dict[str, Any] = {
        "number": number,
        "set": "laboratory",
        "seed": seed,
        "type": test.type,
        "base": test.base,
        "error": test.error,
        "truth": [f"{name} {effect}" for name, effect in zip(test.names, test.hidden, strict=True)],
        "verdict": "failed",
        "steps": [],
        "right": False,
        "visible": True,
    }
    try:
        found = diagnose_with_options(
            structure_of(test.model),
            measurement_of(test.plan, measured),
            DiagnosisOptions(suspects=suspects, tolerances=TolerancePreset(test.error)),
        )
        line |= score(test, found)
    except Exception:  # the trial goes on and counts it as wrong
        line["trouble"] = traceback.format_exc(limit=-6)
    return line | {"seconds": time.process_time() - start}


def counted(lines: Sequence[dict[str, Any]], type_: str) -> list[dict[str, Any]]:
    """Return the lines of a type that count."""
    return [line for line in lines if line["type"] == type_ and line["visible"]]


def report(lines: Sequence[dict[str, Any]]) -> str:
    """Return shares, times and calibration as text."""
    told = []
    for by in ("error", "base"):
        for name in sorted({line[by] for line in lines}):
            chosen = [line for line in counted(lines, "single") if line[by] == name]
            told.append(f"single, {name:<12} {sum(line['right'] for line in chosen)} of {len(chosen)}")
    for type_ in ("single", "pair", "nothing", "unknown"):
        chosen = counted(lines, type_)
        if chosen:
            right = sum(line["right"] for line in chosen)
            told.append(f"{type_:<20} {right} of {len(chosen)}, {right / len(chosen):.0%}")
    wrong = Counter(
        line["type"]
        for line in lines
        if any(step["probability"] > SURE and not step["true"] for step in line["steps"])
    )
    told.append(f"a wrong name with probability above {SURE}: {dict(wrong)}")
    told.append(f"verdicts: {dict(Counter(line['verdict'] for line in lines))}")
    seconds = [line["seconds"] for line in lines]
    told.append(f"CPU time: median {np.median(seconds):.1f} s, worst {max(seconds):.0f} s")
    return "\n".join([*told, *calibration(lines)])


def trial(
    numbers: Sequence[int],
    seed: int,
    workers: int,
    out: Path | None,
    suspects: tuple[str, ...] | None = None,
) -> list[dict[str, Any]]:
    """Return the lines of tests, each written down and printed as soon as it is done."""
    lines = []
    with ProcessPoolExecutor(workers) as pool:
        for task in as_completed([pool.submit(run_test, number, seed, suspects) for number in numbers]):
            line = task.result()
            lines.append(line)
            if out is not None:
                with out.open("a") as file:
                    file.write(json.dumps(line) + "\n")
            named = ", ".join(f"{s['kind']} {s['at']} p {s['probability']:.2f}" for s in line["steps"])
            print(
                f"{line['number']:4d} {'right' if line['right'] else 'WRONG'} {line['type']} {line['base']} "
                f"{line['error']} {line['truth']}: {line['verdict']} {named} {line['seconds']:.1f} s",
                flush=True,
            )
    return lines


def run(numbers: Sequence[int] = QUICK, seed: int = 1, suspects: tuple[str, ...] | None = None) -> list[Row]:
    """Return (name, figure, limit): shares of wrong answers."""
    lines = trial(numbers, seed, 1, None, suspects)
    print(report(lines))
    rows: list[Row] = []
    for type_, least in LIMITS.items():
        if chosen := counted(lines, type_):
            wrong = np.mean([not line["right"] for line in chosen])
            rows.append((f"laboratory: {type_}, share wrong", float(wrong), 1 - least))
    return rows


def _options() -> Namespace:
    arguments = parser(__doc__)
    arguments.add_argument("--count", type=int, default=200)
    arguments.add_argument("--only", type=int, nargs="*", help="numbers of tests instead")
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--suspects", nargs="*", help="kinds of effects to look for; default: all")
    arguments.add_argument("--workers", type=int, default=2)
    arguments.add_argument("--out", type=Path, help="a line a test; those that are there are not repeated")
    arguments.add_argument("--report", type=Path, nargs="*", help="lines to report, and nothing is run")
    return arguments.parse_args()


def read(path: Path) -> list[dict[str, Any]]:
    """Return the lines of a file; none if there is no such file."""
    return [json.loads(text) for text in path.read_text().splitlines()] if path.exists() else []


def main() -> None:
    """Run tests and print what became of them."""
    options = _options()
    if options.report:
        print(report([line for path in options.report for line in read(path)]))
        return
    known = read(options.out) if options.out else []
    finished = {(line["seed"], line["number"]) for line in known}
    numbers = range(options.count) if options.only is None else options.only
    left = [number for number in numbers if (options.seed, number) not in finished]
    suspects = tuple(options.suspects) if options.suspects else None
    print(report(known + trial(left, options.seed, options.workers, options.out, suspects)))


BENCH = Bench(full=run, short=lambda: run((5,), suspects=("gain_error",)))

if __name__ == "__main__":
    main()
