"""How surely all coefficients are found at once on frequency responses, without noise and with it.

python -m benchmarks frf_residual
"""

from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from benchmarks.bench import Bench
from benchmarks.one_shot import BAY, CLOSE, DOFS, ELEMENTWISE, MEMBERS, pattern, true_bay
from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.damping import StructuralDamping
from modallab.fe.receptance import direct_receptance
from modallab.fe.structure import Structure
from modallab.rig.analyser import Analyser
from modallab.rig.hardware import Noise
from modallab.rig.measure import Route, measure
from modallab.rig.noise_bias import without_noise_bias
from modallab.rig.setup import RigSetup
from modallab.updating.method import UpdateResult
from modallab.updating.parameterisation import Parameterisation, parameterise
from modallab.updating.responses.method import RESPONSE_UPDATERS
from modallab.updating.responses.target import TargetResponses, target_responses

PATTERNS, SEEDS, MORE_SEEDS = 50, 20, 50
LOSS = 0.01
DRIVE = (Dof(1, "Y"),)
LINES = np.linspace(32.0, 1280.0, 40)  # to just above the tenth elastic mode of the bay, Hz
AVERAGES = 100.0
COHERENCE = 0.98
NOISE = Noise(force=0.01, response=1e-4)  # of the mean spectra: a tenth of the force's size
BEAM = STRUCTURES["chapter-5-beam"]()
BEAM_EACH = parameterise([(member.number,) for member in BEAM.members])
BEAM_DOFS = tuple(Dof(node, "Y") for node in range(1, 22))
BEAM_LINES = np.linspace(10.0, 1600.0, 160)  # 13 elastic modes


def damped(structure: Structure) -> Structure:
    """Return a structure that loses one per cent."""
    return replace(structure, damping=StructuralDamping(stiffness_coefficient=LOSS))


def responses(
    structure: Structure, lines: FloatArray, outputs: tuple[Dof, ...], inputs: tuple[Dof, ...]
) -> FrfSet:
    """Return exact receptances of a structure, solved for line by line."""
    system = assemble(structure)
    values = direct_receptance(system, lines, system.selection(outputs), system.selection(inputs))
    return FrfSet(lines, values, outputs, inputs, FrfKind.RECEPTANCE)


def exact(frf: FrfSet) -> TargetResponses:
    """Return responses that have no random error."""
    return target_responses(frf, np.ones(frf.values.shape[:2]), AVERAGES)


def noisy(frf: FrfSet, seed: int, coherence: float = COHERENCE) -> TargetResponses:
    """Return responses with independent noise of that coherence, and with the estimated coherence."""
    rng = np.random.default_rng(seed)
    loose = (1 - coherence) / coherence
    noise = np.sqrt(loose / (2 * AVERAGES)) * rng.standard_normal((2, *frf.values.shape))
    values = frf.values * (1 + noise[0] + 1j * noise[1])
    noise_power = loose * rng.standard_gamma(AVERAGES - 1, values.shape) / AVERAGES * np.abs(frf.values) ** 2
    estimate = np.abs(values) ** 2 / (np.abs(values) ** 2 + noise_power)
    return target_responses(replace(frf, values=values), estimate, AVERAGES)


def wrong_beam(seed: int) -> tuple[Structure, dict[tuple[str, int], float]]:
    """Return the beam with one to six wrong members, as `one_shot.pattern` has them of the bay."""
    wrong = {(part, (n - 1) % len(BEAM.members) + 1): f for (part, n), f in pattern(seed).items()}
    kinds = {"mass": MemberProperty.DENSITY, "stiffness": MemberProperty.MODULUS}
    return change(BEAM, [MemberChange((n,), kinds[p], factor=f) for (p, n), f in wrong.items()]), wrong


def update(structure: Structure, parameters: Parameterisation, target: TargetResponses) -> UpdateResult:
    """Return the structure updated on responses."""
    return RESPONSE_UPDATERS["frf_residual"](structure, parameters, target)


def worst(result: UpdateResult, wrong: dict[tuple[str, int], float]) -> float:
    """Return the largest error of a coefficient."""
    tables = result.coefficients.items()
    return max(abs(v - wrong.get((part, n), 1.0)) for part, table in tables for n, v in table.items())


def of_bay(seed: int, loss: float = LOSS) -> float:
    """Return the largest error of 62 coefficients of the bay from exact responses to one force."""
    wrong, law = pattern(seed), StructuralDamping(stiffness_coefficient=loss)
    truth = replace(true_bay(wrong), damping=law)
    return worst(
        update(replace(BAY, damping=law), ELEMENTWISE, exact(responses(truth, LINES, DOFS, DRIVE))), wrong
    )


def of_beam(seed: int) -> float:
    """Return the largest error of 40 coefficients of the beam from exact responses to one force."""
    truth, wrong = wrong_beam(seed)
    return worst(update(BEAM, BEAM_EACH, exact(responses(truth, BEAM_LINES, BEAM_DOFS, DRIVE))), wrong)


@dataclass(frozen=True)
class Found:
    """How one draw of noise went."""

    covered: float  # share of coefficients inside their intervals
    worst: float  # largest error of a coefficient
    mean_square: float  # mean square of what is left over its random error


@cache
def _noisy_case() -> tuple[FrfSet, dict[tuple[str, int], float]]:
    wrong = pattern(0)
    return responses(damped(true_bay(wrong)), LINES, DOFS, DRIVE), wrong


def of_noise(seed: int) -> Found:
    """Return how one draw of noise on the first pattern of the bay went."""
    frf, wrong = _noisy_case()
    return _outcome(update(damped(BAY), ELEMENTWISE, noisy(frf, seed)), wrong)


def of_force_noise(case: str, seed: int) -> Found:
    """Return how a test of the bay or the beam went whose force has a noise that all responses share."""
    truth, wrong = (damped(true_bay(pattern(0))), pattern(0)) if case == "bay" else wrong_beam(0)
    lines, dofs = (LINES, DOFS) if case == "bay" else (BEAM_LINES, BEAM_DOFS)
    analyser = Analyser(lines[-1], len(lines) + 1, averages=int(AVERAGES))
    setup = RigSetup(drives=DRIVE, responses=dofs, noise=NOISE, analyser=analyser)
    test = measure(truth, setup, route=Route.DRAWN, rng=np.random.default_rng(seed))
    frf, common = without_noise_bias(test)
    target = target_responses(frf, test.coherence, test.averages, common=common)
    model, parameters = (damped(BAY), ELEMENTWISE) if case == "bay" else (BEAM, BEAM_EACH)
    return _outcome(update(model, parameters, target), wrong)


def _outcome(result: UpdateResult, wrong: dict[tuple[str, int], float]) -> Found:
    inside = [
        low <= wrong.get((part, number), 1.0) <= high
        for part, table in result.intervals.items()
        for number, (low, high) in table.items()
    ]
    assert result.responses is not None
    return Found(float(np.mean(inside)), worst(result, wrong), result.responses.after)


def run(
    patterns: int = PATTERNS, seeds: int = SEEDS, more_seeds: int = MORE_SEEDS
) -> list[tuple[str, float, float]]:
    """Return (name, figure, limit): of patterns not found, and of noise."""
    bay = sum(of_bay(seed) >= CLOSE for seed in range(patterns))
    beam = sum(of_beam(seed) >= CLOSE for seed in range(patterns))
    noisy_runs = [of_noise(seed) for seed in range(seeds)]
    covered = float(np.mean([run.covered for run in noisy_runs]))
    forced = {
        case: float(np.mean([of_force_noise(case, seed).covered for seed in range(more_seeds)]))
        for case in ("bay", "beam")
    }
    two_sided = [
        (f"frf_residual, noise of the force, {case}: 95 % intervals {label}", figure, limit)
        for case, share in forced.items()
        for label, figure, limit in (("that miss the truth", 1 - share, 0.10), ("that hold it", share, 0.99))
    ]
    return [
        (f"frf_residual: of {patterns} patterns of {2 * len(MEMBERS)} coefficients not exact", bay, 2.0),
        (f"frf_residual: of {patterns} patterns of the beam not exact", beam, 2.0),
        ("frf_residual, noise: 95 % intervals that miss the truth", 1 - covered, 0.10),
        ("frf_residual, noise: those that hold it", covered, 0.99),
        (
            "frf_residual, noise: worst coefficient, median",
            float(np.median([o.worst for o in noisy_runs])),
            0.05,
        ),
        ("frf_residual, noise: mean square left, largest", max(run.mean_square for run in noisy_runs), 1.2),
        *two_sided,
    ]


BENCH = Bench(run, short=partial(run, patterns=1, seeds=1, more_seeds=1))
