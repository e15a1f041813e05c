"""Effects that no catalogue holds: are they placed, described, and closed by what is adopted?

Each case hides one effect at a random place of a free beam: a fractional damper, a feedback with a delay, an
absorber of two modes, or a channel whose gain depends on frequency. FRFs are exact receptances by the beam's
matrices, with noise of responses by averages; FRFs and coherence alone are handed over. A diagnosis sees
three lines of four in blocks, and not the held-out responses. What it adopts is then held against all that
it has not seen, and beside it the same curve solved for at a random DoF.

    python -m benchmarks.unknown_effects --kind feedback --count 20 --seed 0
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from benchmarks.bench import Bench, Row, parser
from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.numerics import SAFE_DIVISOR
from modallab.core.place import Channels
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import residual
from modallab.diagnosis.result import CurveModelName, Diagnosis, Unknown, UnknownCause
from modallab.diagnosis.result_builder import extended
from modallab.diagnosis.unknown.adoption import adopted_effect
from modallab.diagnosis.unknown.places import UnknownPlace
from modallab.diagnosis.unknown.solve import unknown_effect_at
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Material, Section, Structure
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.hardware import Accelerometers, Exciter, Noise
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup

N_ELEMENTS, LOSS_FACTOR = 20, 0.005
DRIVE = Dof(7, "Y")
RESPONSES = tuple(Dof(node, "Y") for node in (1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 20, 21))
HELD_OUT = (Dof(3, "Y"), Dof(11, "Y"), Dof(17, "Y"))
FREQ = np.linspace(2.0, 800.0, 400)  # Hz
BLOCK, AVERAGES, NOISE = 10, 40, 1e-4  # lines; averages; power of noise over mean power of a response
SIZES = 0.001, 0.03  # of the effect's dynamic stiffness over that of the beam, median of the lines
LARGEST_GAIN = 0.8  # of a feedback over that at which the structure is unstable
SEED_OF_KIND = {"fractional": 1, "feedback": 2, "absorber": 3, "gain": 4}
CURVE_MODELS = {
    "fractional": {CurveModelName.POWER},
    "feedback": {CurveModelName.DELAYED_VELOCITY_FEEDBACK},
    "absorber": {CurveModelName.TWO_OSCILLATORS},
    "gain": {CurveModelName.FIRST_ORDER_LOW_PASS},
}


@dataclass(frozen=True, eq=False)
class Hidden:
    """An effect that no catalogue holds."""

    kind: str
    at: Dof
    """DoF of the force, or of the channel."""
    source: Dof
    """DoF whose motion drives the force."""
    curve: ComplexArray
    """(n_freq,) N/m, dynamic stiffness; of a channel its gain."""


@dataclass(frozen=True)
class Score:
    """What was found of one hidden effect."""

    placed: bool
    described: bool
    closed: float
    """1, share of the gap's excess over 1 that the adopted effect closes in what was held out."""
    closed_at_random: float
    """The same of a curve solved for at a random DoF."""
    seconds: float
    label: str


def model() -> Structure:
    """Return a free beam with nine modes below 800 Hz."""
    return beam(
        length=1.5,
        n_elements=N_ELEMENTS,
        section=Section(5e-4, 4.1667e-9),
        material=Material(2.09e11, 7800.0),
        damping=StructuralDamping(stiffness_coefficient=LOSS_FACTOR),
    )


def receptances(structure: Structure, dofs: Sequence[Dof]) -> ComplexArray:
    """Return the receptances (n_freq, n, n) between DoFs, m/N."""
    system = assemble(structure)
    omega = 2 * np.pi * FREQ[:, None, None]
    dynamic = system.stiffness.toarray() * (1 + 1j * LOSS_FACTOR) - omega**2 * system.mass.toarray()
    columns = system.selection(tuple(dofs))
    return np.asarray(
        columns.T @ np.linalg.solve(dynamic, np.broadcast_to(columns, (len(FREQ), *columns.shape)))
    )


def hidden(kind: str, rng: np.random.Generator, direct: FloatArray) -> Hidden:
    """Return an effect of a kind at a random place.

    Parameters
    ----------
    direct
        (n_nodes,) N/m, median dynamic stiffness of the beam at each node.
    """
    omega, middle = 2 * np.pi * FREQ, 2 * np.pi * 300.0
    nodes = rng.permutation(np.arange(1, N_ELEMENTS + 2))
    nodes = nodes[nodes != DRIVE.node]  # a force at the drive is a gain of all channels
    at = source = Dof(int(nodes[0]), "Y")
    size = float(np.exp(rng.uniform(*np.log(SIZES)))) * direct[at.node - 1]
    if kind == "fractional":
        curve = size * (1j * omega / middle) ** 0.5
    elif kind == "feedback":
        source = Dof(int(nodes[1]), "Y")
        curve = size * 1j * omega / middle * np.exp(-1j * omega * rng.uniform(0.2e-3, 3e-3))
        curve = curve * min(1.0, LARGEST_GAIN * stable_gain(at, source, curve))
    elif kind == "absorber":
        own = (2 * np.pi * rng.uniform([100.0, 300.0], [250.0, 700.0])) ** 2 * (
            1 + 1j * rng.uniform(0.01, 0.05, 2)
        )
        mass = size / middle**2 * rng.uniform(0.3, 1.0, 2)
        curve = -(mass * omega[:, None] ** 2 * own / (own - omega[:, None] ** 2)).sum(axis=1)
    else:
        at = source = RESPONSES[int(rng.choice([i for i, r in enumerate(RESPONSES) if r not in HELD_OUT]))]
        corner = float(np.exp(rng.uniform(*np.log((50.0, 2000.0)))))
        curve = 1 / (1 + 1j * FREQ / corner)  # a high-pass would be an AC coupling, which the catalogue holds
    return Hidden(kind, at, source, np.asarray(curve))


def stable_gain(at: Dof, source: Dof, curve: ComplexArray) -> float:
    """Return the factor of a feedback's curve at which the damping of some mode vanishes, to first order."""
    system = assemble(model())
    squares, shapes = scipy.linalg.eigh(system.stiffness.toarray(), system.mass.toarray())
    elastic = (squares > (2 * np.pi * FREQ[0]) ** 2) & (squares < (2 * np.pi * FREQ[-1]) ** 2)
    products = (system.selection((at,)).T @ shapes * (system.selection((source,)).T @ shapes))[0, elastic]
    force = np.interp(np.sqrt(squares[elastic]), 2 * np.pi * FREQ, curve.imag)
    damping = force * products / (LOSS_FACTOR * squares[elastic])
    return float(-1 / min(damping.min(), -SAFE_DIVISOR))


def measured(effect: Hidden, alpha: ComplexArray, rng: np.random.Generator) -> Measurement:
    """Return the test of the beam with a hidden effect: FRFs and coherence from averages of noisy records."""
    output = [r.node - 1 for r in RESPONSES]
    x, y, d = effect.at.node - 1, effect.source.node - 1, DRIVE.node - 1
    h = alpha[:, output, d]
    if effect.kind == "gain":
        h = h * np.where(np.array(RESPONSES) == effect.at, effect.curve[:, None], 1.0)
    else:
        share = effect.curve * alpha[:, y, d] / (1 + effect.curve * alpha[:, y, x])
        h = h - alpha[:, output, x] * share[:, None]
    h = -((2 * np.pi * FREQ) ** 2)[:, None] * h
    drawn = rng.standard_normal((2, len(FREQ), len(output) + 1, AVERAGES)) / np.sqrt(2)
    force, noise = np.split(drawn[0] + 1j * drawn[1], [1], axis=1)
    level = np.sqrt(NOISE * (np.abs(h) ** 2).mean())
    response = h[:, :, None] * force + level * noise
    cross = (force.conj() * response).mean(axis=2)
    ff, xx = ((np.abs(each) ** 2).mean(axis=2) for each in (force, response))
    setup = RigSetup(
        drives=(DRIVE,),
        responses=RESPONSES,
        exciter=Exciter(armature_mass=0.0),
        accelerometers=Accelerometers(mass=0.0),
        noise=Noise(None, None),
        analyser=Analyser(
            frequency_max=FREQ[-1],
            n_lines=len(FREQ) + 1,
            window="rectangular",
            averages=AVERAGES,
            excitation=ExcitationSetting("periodic_random", level=None),
        ),
    )
    frf = FrfSet(FREQ, (cross / ff)[:, :, None], RESPONSES, (DRIVE,), FrfKind.INERTANCE)
    return Measurement(frf, np.abs(cross) ** 2 / (ff * xx), AVERAGES, setup)


def seen_lines() -> BoolArray:
    """Return the lines (n_freq,) that a diagnosis sees: three blocks of four."""
    return np.asarray(np.arange(len(FREQ)) // BLOCK % 4 != 3)


def unseen(observed: Observed) -> BoolArray:
    """Return the entries (n_freq, n_frf) that no fit has seen: held-out responses, and blocks of lines."""
    blocks = np.interp(observed.freq, FREQ, ~seen_lines()) > 0.5
    responses = [channel.response.point in HELD_OUT for channel in observed.channels]
    return np.asarray(observed.usable & (responses | blocks[:, None]))


def gap_of(structure: Structure, setup: RigSetup, whole: Measurement) -> float:
    """Return the gap of a model, with a log book, in what was held out of a whole test."""
    observed = observe(replace(whole, setup=setup), (), fraction=0.0)
    predictor = SingleTestPredictor.of(structure, setup, observed)
    return residual(observed, predictor.predict(())).gaps(unseen(observed))["frf"]


def closed(before: float, after: float) -> float:
    """Return the share of the excess of a gap over 1 that is closed."""
    return (before - after) / (before - 1)


def found_place(found: Unknown, effect: Hidden) -> bool:
    """Return whether the place is right, or among at most three that cannot be distinguished from it."""
    at = Channels((effect.at,)) if effect.kind == "gain" else effect.at
    rivals = [rival.at for rival in found.rivals_alike]
    return found.at == at or (len(rivals) <= 3 and at in rivals)


def random_place(rng: np.random.Generator, effect: Hidden) -> UnknownPlace:
    """Return a DoF at which nothing was hidden."""
    nodes = [n for n in range(1, N_ELEMENTS + 2) if n not in (effect.at.node, DRIVE.node)]
    return UnknownPlace(UnknownCause.INTERNAL_FORCE, Dof(int(rng.choice(nodes)), "Y"))


def score(kind: str, seed: int, suspects: Sequence[str] | None) -> Score:
    """Return what a diagnosis finds of one hidden effect.

    Parameters
    ----------
    suspects
        Kinds of effects that the diagnosis considers; None for all.
    """
    rng = np.random.default_rng([SEED_OF_KIND[kind], seed])
    structure = model()
    alpha = receptances(structure, [Dof(n, "Y") for n in range(1, N_ELEMENTS + 2)])
    direct = np.median(1 / np.abs(alpha.diagonal(axis1=1, axis2=2)), axis=0)
    effect = hidden(kind, rng, direct)
    whole = measured(effect, alpha, rng)
    part = whole.at(seen_lines())
    start = time.process_time()
    found = diagnose(structure, part, suspects=suspects, hold_out=HELD_OUT)
    seconds = time.process_time() - start
    before = gap_of(structure, whole.setup, whole)
    label = f"{effect.at} by {effect.source}, gap {before:.3g}: {found.verdict}"
    if found.unknown is None:
        names = ", ".join(f"{step.effect.kind} {step.effect.at}" for step in found.steps)
        return Score(False, False, 0.0, np.nan, seconds, f"{label}, {names or 'nothing'}")
    after = gap_of(*adopting(structure, part, found, found.unknown), whole)
    observed = observe(part, (), fraction=0.0)
    predictor = SingleTestPredictor.of(structure, part.setup, observed)
    elsewhere = unknown_effect_at(predictor, fit(predictor, ()), random_place(rng, effect))
    at_random = gap_of(*adopting(structure, part, found, elsewhere), whole)
    unknown = found.unknown
    return Score(
        placed=found_place(unknown, effect),
        described=unknown.curve_model in CURVE_MODELS[kind],
        closed=closed(before, after),
        closed_at_random=closed(before, at_random),
        seconds=seconds,
        label=f"{label}, {unknown.cause} {unknown.at}, {unknown.curve_model} of {unknown.source}, "
        f"{len(unknown.rivals_alike)} alike, left {after:.3g}",
    )


def adopting(
    structure: Structure, test: Measurement, found: Diagnosis, unknown: Unknown
) -> tuple[Structure, RigSetup]:
    """Return model and log book with an adopted effect, beside the effects that act beside it."""
    beside = (found.structure, found.setup) if unknown.beside_steps else (structure, test.setup)
    return extended(*beside, [adopted_effect(unknown, test.frf.freq)])


def run(kinds: Sequence[str], count: int, seed: int, suspects: Sequence[str] | None) -> list[Row]:
    """Return (name, figure, limit) of each kind: shares that fall short, each over the share that may."""
    found: list[Row] = []
    for kind in kinds:
        scores = []
        for each in range(seed, seed + count):
            scores.append(score(kind, each, suspects))
            s = scores[-1]
            print(
                f"{kind} {each}: {s.label}; closed {s.closed:.3f}, at random {s.closed_at_random:.3f}; "
                f"{s.seconds:.1f} s",
                flush=True,
            )
        placed = [s for s in scores if s.placed]
        shares = {
            "misplaced": (np.mean([not s.placed for s in scores]), 0.2),
            "placed, of another model": (np.mean([not s.described for s in placed] or [True]), 0.4),
            "held-out gap not closed by 90 %": (np.mean([not s.closed > 0.9 for s in scores]), 0.2),
        }
        found += [(f"{kind}, {name}", float(share), limit) for name, (share, limit) in shares.items()]
        at_random = np.nanmean([s.closed_at_random > 0.3 for s in scores])
        print(f"{kind}: a curve at a random DoF closes over 30 % in {at_random:.0%} of the cases", flush=True)
    return found


FEW = ("polarity",)  # kinds that explain none of it


def main() -> None:
    """Print what is found of every case, and the shares."""
    arguments = parser(__doc__)
    arguments.add_argument("--kind", choices=SEED_OF_KIND, action="append")
    arguments.add_argument("--count", type=int, default=20)
    arguments.add_argument("--seed", type=int, default=0)
    arguments.add_argument("--few", action="store_true", help="without the catalogue, in seconds a case")
    options = arguments.parse_args()
    kinds = options.kind or list(SEED_OF_KIND)
    for name, figure, limit in run(kinds, options.count, options.seed, FEW if options.few else None):
        print(f"{name:<60} {figure:.2f}  limit {limit}")


BENCH = Bench(full=lambda: run(list(SEED_OF_KIND), 5, 0, FEW), short=lambda: run(["fractional"], 1, 0, FEW))

if __name__ == "__main__":
    main()
