"""Is the right member of a fine, lightly damped bar named?

A free bar of 52 elements has one member softer or stiffer than its model. Its FRFs are exact, with 5 % noise
at every line: one input, nine responses, lines of 0.3125 Hz. A member is separable if the best fit of any
other one, its factor free, is worse by more than 10 in log-likelihood. Of separable members the right one
is to be named first; of others the right one, or it is to be among `rivals_alike`; nothing else alone may
explain the test.

    python -m benchmarks.control_bar --members 3 10 26 31 --factors 0.7 1.3 --draws 1
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from benchmarks.bench import Bench, Row, parser
from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.place import Members
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.result import Verdict
from modallab.effects.stiffness_error import StiffnessError
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.damping import StructuralDamping
from modallab.fe.receptance import receptance
from modallab.fe.structure import Material, Section, Structure
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.hardware import Accelerometers, Exciter, Noise
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup

N_ELEMENTS, LENGTH, LOSS_FACTOR = 52, 1.3, 2.5e-4
DRIVE = Dof(5, "Y")
RESPONSES = tuple(Dof(node, "Y") for node in (1, 8, 14, 21, 27, 33, 40, 46, 53))
FREQ = np.asarray(np.arange(1, 3201) * 0.3125, np.float64)  # Hz
NOISE = 0.05  # standard deviation of the magnitude of an FRF over itself
AVERAGES = 20
MEMBERS = 3, 10, 17, 26, 31, 40, 48
FACTORS = 0.7, 0.9, 1.3
SEPARABLE = 10.0  # log-likelihood
MISSED = 0.04


@dataclass(frozen=True)
class Outcome:
    """What a diagnosis says of one wrong member."""

    separable: bool
    first: bool
    alike: bool
    """Whether the right member is first or among those that cannot be distinguished from the first."""
    misled: bool
    """Whether another effect alone is said to explain the test."""


def bar() -> Structure:
    """Return the free bar, 14 modes below 1 kHz."""
    return beam(
        length=LENGTH,
        n_elements=N_ELEMENTS,
        section=Section(area=1.6e-4, second_moment=8.533e-10),
        material=Material(modulus=2.06e11, density=7850.0),
        damping=StructuralDamping(stiffness_coefficient=LOSS_FACTOR),
    )


def inertance(structure: Structure, member: int | None = None, factor: float = 1.0) -> ComplexArray:
    """Return the inertances (n_freq, n_responses), one member's modulus times a factor."""
    if member is not None:
        structure = StiffnessError(Members((member,)), factor).added_to(structure)
    system = assemble(structure)
    alpha = receptance(system, FREQ, system.selection(RESPONSES), system.selection((DRIVE,)))
    return np.asarray(-((2 * np.pi * FREQ) ** 2)[:, None] * alpha[..., 0])


def measured(h: ComplexArray, rng: np.random.Generator) -> Measurement:
    """Return FRFs and coherence of averages whose responses have noise in proportion to themselves."""
    drawn = rng.standard_normal((2, len(FREQ), len(RESPONSES) + 1, AVERAGES)) / np.sqrt(2)
    force, noise = np.split(drawn[0] + 1j * drawn[1], [1], axis=1)
    response = h[:, :, None] * (force + np.sqrt(2 * AVERAGES) * NOISE * noise)
    cross = (force.conj() * response).mean(axis=2)
    ff, xx = ((np.abs(each) ** 2).mean(axis=2) for each in (force, response))
    analyser = Analyser(
        frequency_max=FREQ[-1],
        n_lines=len(FREQ) + 1,
        window="rectangular",
        averages=AVERAGES,
        excitation=ExcitationSetting("periodic_random", level=None),
    )
    setup = RigSetup(
        drives=(DRIVE,),
        responses=RESPONSES,
        exciter=Exciter(armature_mass=0.0),
        accelerometers=Accelerometers(mass=0.0),
        noise=Noise(None, None),
        analyser=analyser,
    )
    frf = FrfSet(FREQ, (cross / ff)[:, :, None], RESPONSES, (DRIVE,), FrfKind.INERTANCE)
    return Measurement(frf, np.abs(cross) ** 2 / (ff * xx), AVERAGES, setup)


def log_likelihood(structure: Structure, test: Measurement, member: int, factor: float) -> float:
    """Return the logarithm of the likelihood of a test with one member's factor."""
    difference = test.frf.values[..., 0] / inertance(structure, member, factor) - 1
    return -float((np.abs(difference) ** 2).sum()) / (2 * NOISE**2)


def best_log_likelihood(structure: Structure, test: Measurement, member: int, near: float) -> float:
    """Return the largest log-likelihood of a member, its factor free about a power of another."""

    def cost(logarithm: float) -> float:
        return -log_likelihood(structure, test, member, float(np.exp(logarithm)))

    trials = np.log(near) * np.linspace(-0.5, 3.0, 29)
    start = trials[int(np.argmin([cost(each) for each in trials]))]
    step = abs(trials[1] - trials[0])
    found = scipy.optimize.minimize_scalar(cost, bounds=(start - step, start + step), method="bounded")
    return -float(found.fun)


def outcome(member: int, factor: float, draw: int, suspects: Sequence[str] | None = None) -> Outcome:
    """Return what a diagnosis says of one wrong member; print it."""
    rng = np.random.default_rng([member, round(100 * factor), draw])
    structure = bar()
    test = measured(inertance(structure, member, factor), rng)
    # Neighbours and mirror images imitate a member; others are worse by thousands.
    near = {member + step for step in (-2, -1, 1, 2)} | {
        N_ELEMENTS + 1 - member + step for step in (-1, 0, 1)
    }
    others = sorted(other for other in near - {member} if 1 <= other <= N_ELEMENTS)
    best = max(best_log_likelihood(structure, test, other, factor) for other in others)
    separable = log_likelihood(structure, test, member, factor) - best > SEPARABLE
    start = time.process_time()
    found = diagnose(structure, test, suspects=suspects)
    seconds = time.process_time() - start
    at = Members((member,))
    named = [(step.effect.kind, step.effect.at) for step in found.steps]
    alike = {(rival.kind, rival.at) for step in found.steps[:1] for rival in step.rivals_alike}
    right = ("stiffness_error", at)
    first = named[:1] == [right]
    names = ", ".join(f"{kind} {place}" for kind, place in named) or "nothing"
    print(
        f"member {member:2d} x {factor}, draw {draw}: {'separable' if separable else 'not separable'}, "
        f"{found.verdict}: {names}, gap {found.remaining_gap:.2f}, {seconds:.1f} s",
        flush=True,
    )
    misled = found.verdict is Verdict.EXPLAINED and right not in named
    return Outcome(separable, first, first or right in alike, misled)


def run(
    members: Sequence[int], factors: Sequence[float], draws: int, suspects: Sequence[str] | None = None
) -> list[Row]:
    """Return (name, figure, limit): shares of separable and other members that are not named, or mislead."""
    cases = [(m, factor, draw) for m in members for factor in factors for draw in range(draws)]
    found = [outcome(*case, suspects) for case in cases]
    separable, others = ([o for o in found if o.separable is flag] for flag in (True, False))
    print(f"{len(separable)} separable, {len(others)} not", flush=True)
    shares = {
        "separable, the right member not first": (
            np.mean([not o.first for o in separable] or [False]),
            MISSED,
        ),
        "not separable, the right member not listed": (
            np.mean([not o.alike for o in others] or [False]),
            MISSED,
        ),
        "another effect alone explains": (np.mean([o.misled for o in found]), 0.0),
    }
    return [(name, float(share), limit) for name, (share, limit) in shares.items()]


def main() -> None:
    """Print what is named for every member, factor and draw, and the shares."""
    arguments = parser(__doc__)
    arguments.add_argument("--members", type=int, nargs="+", default=MEMBERS)
    arguments.add_argument("--factors", type=float, nargs="+", default=FACTORS)
    arguments.add_argument("--draws", type=int, default=3)
    arguments.add_argument("--suspects", nargs="*", help="kinds of effects to look for; default: all")
    options = arguments.parse_args()
    for name, figure, limit in run(options.members, options.factors, options.draws, options.suspects):
        print(f"{name:<60} {figure:.3f}  limit {limit}")


BENCH = Bench(
    full=lambda: run(MEMBERS, (0.7,), 1),
    short=lambda: run((26,), (0.7,), 1, ["stiffness_error", "density_error"]),
)

if __name__ == "__main__":
    main()
