"""Are effects with a resonance of their own found, wherever in the band it lies?

A flexible stinger, an attached oscillator or a compliant mounting of the accelerometers is hidden in tests of
a free beam, at frequencies over the band; one diagnosis each. Found is what is named first, at its place,
with a frequency within 2 %.

    python -m benchmarks.resonant_effects --kind stinger_axial --count 60 --seed 1
"""

import time
from collections.abc import Sequence

import numpy as np

from benchmarks.bench import Bench, Row, parser
from benchmarks.diagnosing import rig
from benchmarks.trial.rigs import free_beam
from modallab.core.dof import Dof
from modallab.core.place import Place
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.result import FittedEffect
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.measure import Route, measure
from modallab.rig.setup import RigSetup

KINDS = "stinger_axial", "attached_oscillator", "mounted_resonance"
OUTPUTS = [Dof(node, "Y") for node in range(1, 22, 2)]
LOWEST = 0.05  # of the top of the band
WITHIN, MISSED = 0.02, 0.05  # of the frequency; of the effects
STINGER_LOSS = 0.02


def frequency(effect: FittedEffect, setup: RigSetup) -> float:
    """Return the frequency, Hz, at which an effect resonates with the structure at rest."""
    if effect.kind != "stinger_axial":
        return effect.parameters["frequency"].value
    stiffness = effect.parameters["stiffness"].value
    return float(np.sqrt(stiffness / setup.exciter.armature_mass) / (2 * np.pi))


def hidden(kind: str, f: float, setup: RigSetup, rng: np.random.Generator) -> Effect:
    """Return an effect of a kind that resonates at a frequency, Hz; an oscillator at a random place."""
    at: Place = None
    numbers = {"frequency": f, "loss": float(rng.uniform(0.02, 0.1))}
    if kind == "stinger_axial":
        stiffness = (2 * np.pi * f) ** 2 * setup.exciter.armature_mass
        numbers = {"stiffness": stiffness, "loss_factor": STINGER_LOSS}
    elif kind == "attached_oscillator":
        at = Dof(int(rng.integers(1, 22)), "Y")
        mass = float(np.exp(rng.uniform(*np.log((0.01, 0.1)))))
        numbers = {"mass": mass, "frequency": f, "loss_factor": float(rng.uniform(0.01, 0.1))}
    return EFFECTS[kind](at=at).with_parameters(numbers)


def missed(kind: str, f: float, seed: int, suspects: Sequence[str] | None) -> bool:
    """Return whether an effect that resonates at a frequency, Hz, is not found; print what was named."""
    rng = np.random.default_rng([KINDS.index(kind), seed, round(f)])
    structure, setup = free_beam(), rig(Dof.parse("1:+Y"), OUTPUTS)
    effect = hidden(kind, f, setup, rng)
    test = measure(structure, setup, [effect], route=Route.DRAWN, rng=rng)
    start = time.process_time()
    found = diagnose(structure, test, suspects=suspects)
    seconds = time.process_time() - start
    steps = [step.effect for step in found.steps]
    named = steps[0] if steps else None
    right = (
        named is not None
        and (named.kind, named.at) == (kind, effect.at)
        and abs(frequency(named, setup) / f - 1) < WITHIN
    )
    names = ", ".join(f"{step.kind} {step.at or ''}" for step in steps) or "nothing"
    if named is not None and named.kind == kind:
        names += f" at {frequency(named, setup):.1f} Hz"
    print(
        f"{kind} {f:.1f} Hz {effect.at or ''}: {'found' if right else 'MISSED'}, {found.verdict}: {names}, "
        f"gap {found.remaining_gap:.2f}, {seconds:.1f} s",
        flush=True,
    )
    return not right


def run(kinds: Sequence[str], count: int, seed: int, suspects: Sequence[str] | None = None) -> list[Row]:
    """Return (name, figure, limit) of each kind: the share that is not found, over that which may be."""
    found: list[Row] = []
    for kind in kinds:
        top = rig(Dof.parse("1:+Y"), OUTPUTS).analyser.freq[-1]
        frequencies = np.geomspace(LOWEST * top, 0.95 * top, count)
        share = np.mean([missed(kind, float(f), seed, suspects) for f in frequencies])
        found.append((f"{kind}, not found or off by over 2 %", float(share), MISSED))
    return found


def main() -> None:
    """Print what is named at every frequency, and the shares."""
    arguments = parser(__doc__)
    arguments.add_argument("--kind", choices=KINDS, action="append")
    arguments.add_argument("--count", type=int, default=60)
    arguments.add_argument("--seed", type=int, default=0)
    arguments.add_argument("--suspects", nargs="*", help="kinds of effects to look for; default: all")
    options = arguments.parse_args()
    for name, figure, limit in run(options.kind or KINDS, options.count, options.seed, options.suspects):
        print(f"{name:<60} {figure:.3f}  limit {limit}")


BENCH = Bench(full=lambda: run(KINDS, 6, 0), short=lambda: run(KINDS[:1], 1, 0, KINDS))

if __name__ == "__main__":
    main()
