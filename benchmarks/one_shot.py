"""How surely all coefficients of a frame are found at once, without noise and with the thesis's NL3.

python -m benchmarks one_shot
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, partial
from itertools import pairwise

import numpy as np

from benchmarks.bench import Bench
from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import ModeNoise, synthetic_modes
from modallab.updating.method import UPDATERS, UpdateResult
from modallab.updating.options import UpdateOptions
from modallab.updating.parameterisation import parameterise

BAY = STRUCTURES["bay"]()
NODES = (1, 3, 5, 7, 8, 10, 13, 14, 16, 18, 20, 23, 26, 28, 30)
DOFS = tuple(Dof(node, direction) for node in NODES for direction in ("X", "Y"))
MODES = 10
MEMBERS = tuple(member.number for member in BAY.members)
ELEMENTWISE = parameterise([(number,) for number in MEMBERS])
BEGIN = (1, 5, 8, 13, 16, 20, 25, 29, 32)  # where the macro elements of the thesis begin
MACROS = parameterise([tuple(range(*ends)) for ends in pairwise(BEGIN)])
PATTERNS = SEEDS = 50
FACTORS = (0.3, 3.0)
MOST_WRONG = 6
CLOSE = 1e-6  # of a coefficient that counts as found
ITERATIONS = 15
NL3 = ModeNoise(eigenvalue=0.005, eigenvector=0.05)
WRONG = {("mass", 25): 1.5, ("mass", 26): 1.5} | {("stiffness", number): 2.0 for number in (12, 13, 31)}
GARTEUR = STRUCTURES["garteur"]()
# every second node of the outline, the third and the fifth of each diagonal
GARTEUR_NODES = (*range(2, 53, 2), *(node + 5 * bay for bay in range(5) for node in (55, 57)))
GARTEUR_WRONG = 10
FRAMES = (1, 2, 3)  # seeds


def true_bay(wrong: dict[tuple[str, int], float]) -> Structure:
    """Return the bay with coefficients that are not 1 on mass or stiffness of members."""
    properties = {"mass": MemberProperty.DENSITY, "stiffness": MemberProperty.MODULUS}
    return change(BAY, [MemberChange((n,), properties[part], factor=f) for (part, n), f in wrong.items()])


def pattern(seed: int) -> dict[tuple[str, int], float]:
    """Return errors of one to six members, in mass, stiffness or both, their logarithms evenly drawn."""
    rng = np.random.default_rng(seed)
    wrong = {}
    for number in rng.choice(MEMBERS, rng.integers(1, MOST_WRONG + 1), replace=False):
        for part in (("mass",), ("stiffness",), ("mass", "stiffness"))[rng.integers(3)]:
            wrong[part, int(number)] = float(np.exp(rng.uniform(*np.log(FACTORS))))
    return wrong


def measured(wrong: dict[tuple[str, int], float], noise: ModeNoise, seed: int) -> ModalModel:
    """Return ten modes of the wrong bay at 30 degrees of freedom."""
    rng = np.random.default_rng(seed)
    return synthetic_modes(assemble(true_bay(wrong)), MODES, DOFS, noise=noise, rng=rng)


def misses(result: UpdateResult, wrong: dict[tuple[str, int], float]) -> FloatArray:
    """Return how far every coefficient ended from the truth, (62,)."""
    return np.array(
        [
            value - wrong.get((part, number), 1.0)
            for part, table in result.coefficients.items()
            for number, value in table.items()
        ]
    )


@dataclass(frozen=True)
class Found:
    """How one draw of noise went."""

    suspected: bool  # every wrong coefficient is among the suspects
    frequency: float  # largest relative error after the update, against the truth
    covered: float  # share of coefficients inside their intervals
    worst: float  # largest error of a coefficient


def exact(seed: int) -> tuple[float, int]:
    """Return the largest error of a coefficient and the iterations of one pattern without noise."""
    wrong, options = pattern(seed), UpdateOptions(max_iterations=ITERATIONS)
    result = UPDATERS["one_shot"](BAY, ELEMENTWISE, measured(wrong, ModeNoise(), 0), options=options)
    return float(np.abs(misses(result, wrong)).max()), result.iterations["updating"]


def garteur(seed: int) -> float:
    """Return the largest error of 166 axial and bending coefficients, from five modes at 72 places.

    Ten members are wrong, in either coefficient by a half to twice as much.
    """
    rng = np.random.default_rng(seed)
    kinds = {"axial": MemberProperty.AXIAL_STIFFNESS, "bending": MemberProperty.BENDING_STIFFNESS}
    numbers = [member.number for member in GARTEUR.members]
    members = [int(n) for n in rng.choice(numbers, GARTEUR_WRONG, replace=False)]
    wrong = {(part, n): float(2 ** rng.uniform(-1, 1)) for n in members for part in kinds}
    changes = [MemberChange((n,), kinds[part], factor=f) for (part, n), f in wrong.items()]
    dofs = tuple(Dof(node, direction) for node in GARTEUR_NODES for direction in ("X", "Y"))
    target = synthetic_modes(assemble(change(GARTEUR, changes)), 5, dofs, noise=ModeNoise(), rng=rng)
    parameters = parameterise([(number,) for number in numbers], tuple(kinds))
    return float(np.abs(misses(UPDATERS["one_shot"](GARTEUR, parameters, target), wrong)).max())


@cache
def true_frequencies() -> FloatArray:
    """Return the frequencies of the Table 3.1 case, Hz."""
    return measured(WRONG, ModeNoise(), 0).frequencies


def noisy(seed: int, method: str = "one_shot") -> Found:
    """Return how one draw of NL3 on the case of table 3.1 went."""
    result = UPDATERS[method](
        BAY, ELEMENTWISE if method == "one_shot" else MACROS, measured(WRONG, NL3, seed)
    )
    inside = [
        low <= WRONG.get((part, number), 1.0) <= high
        for part, table in result.intervals.items()
        for number, (low, high) in table.items()
    ]
    return Found(
        suspected=all(number in result.suspected[part] for part, number in WRONG),
        frequency=float(np.abs(result.frequencies.after / true_frequencies() - 1).max()),
        covered=float(np.mean(inside)) if inside else 0.0,
        worst=float(np.abs(misses(result, WRONG)).max()),
    )


def run(
    patterns: int = PATTERNS, seeds: int = SEEDS, frames: Sequence[int] = FRAMES
) -> list[tuple[str, float, float]]:
    """Return (name, figure, limit): of patterns found, and of noise against location and updating."""
    errors, steps = zip(*(exact(seed) for seed in range(patterns)), strict=True)
    missed = sum(error >= CLOSE for error in errors)
    noisy_runs = [noisy(seed) for seed in range(seeds)]
    plain = [noisy(seed, "inverse_eigensensitivity") for seed in range(seeds)]
    worst = float(np.median([run.worst for run in noisy_runs]))
    covered = float(np.mean([run.covered for run in noisy_runs]))
    largest = max(garteur(seed) for seed in frames)
    return [
        ("one_shot: largest error of 166 coefficients from five modes", largest, 1e-3),
        (f"one_shot: of {patterns} patterns not within {CLOSE:g} in {ITERATIONS} steps", missed, 2.0),
        ("one_shot: most steps of a pattern", max(steps), ITERATIONS),
        (f"one_shot, NL3: of {seeds} draws with a wrong element unsuspected", _unsuspected(noisy_runs), 0.0),
        ("one_shot, NL3: largest error of a frequency", max(run.frequency for run in noisy_runs), 0.003),
        ("one_shot, NL3: 95 % intervals that miss the truth", 1 - covered, 0.10),
        ("one_shot, NL3: those that hold it", covered, 0.99),
        ("one_shot, NL3: worst coefficient, median", worst, 0.235),
        ("one_shot, NL3: the same over two stages'", worst / float(np.median([o.worst for o in plain])), 0.5),
    ]


def _unsuspected(noisy_runs: list[Found]) -> int:
    return sum(not run.suspected for run in noisy_runs)


BENCH = Bench(run, short=partial(run, patterns=1, seeds=1, frames=(1,)))
