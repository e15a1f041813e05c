"""Tests of the laboratory: a structure, a model that is a little wrong, a plan, and what is hidden."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.laboratory.bars import Bars, Reals, correlated
from benchmarks.laboratory.effects import Delay, Effect, Gain
from benchmarks.laboratory.hiding import hide
from benchmarks.laboratory.plan import Plan

STEEL, ALUMINIUM = (2.06e11, 7850.0), (7.1e10, 2700.0)
BASES = "beam", "cantilever", "frame", "fine bar"
ERRORS = "careful", "ordinary", "student"
# One standard deviation each: modulus, its variation along the structure, density, its variation,
# sensitivity, accelerometer mass, delay (s), logarithm of a mode's loss factor.
SIZES = {
    "careful": (0.003, 0.002, 0.002, 0.002, 0.003, 0.01, 1e-6, 0.1),
    "ordinary": (0.01, 0.005, 0.005, 0.005, 0.01, 0.03, 2e-6, 0.2),
    "student": (0.03, 0.02, 0.02, 0.02, 0.03, 0.1, 1e-5, 0.3),
}
VARIATION_LENGTH = 0.15  # over the size of the structure
SINGLES = (
    "extra_mass",
    "stiffness_error",
    "ground_spring",
    "gain_error",
    "attached_oscillator",
    "channel_delay",
    "joint_flexibility",
    "accelerometer_mass",
    "local_damping",
    "swapped_channels",
    "force_transducer_mass",
    "ac_coupling",
    "rotational_ground_spring",
    "polarity",
    "stinger_axial",
    "misplaced_accelerometer",
    "loss_factor_error",
    "mains_hum",
)
UNKNOWN = "fractional_damper", "gain_bump"
TYPES = "single", "single", "single", "pair", "single", "nothing", "single", "pair", "single", "unknown"


@dataclass(frozen=True, eq=False)
class DrawnTest:
    """One test with its truth."""

    number: int
    type: str
    base: str
    error: str
    """How well the model is known."""
    model: Bars
    """The model, as its owner has it."""
    true: Bars
    """The structure, without what is hidden."""
    plan: Plan
    """The log book."""
    true_plan: Plan
    """The rig, without what is hidden."""
    deviations: tuple[Effect, ...]
    """Small errors of the transducers."""
    names: tuple[str, ...]
    """Names of what is hidden."""
    hidden: tuple[Effect, ...]
    seed: int
    """Seed of the measurement."""


def bars_of(base: str) -> Bars:
    """Return the model of a base."""
    modulus, density = ALUMINIUM if base == "frame" else STEEL
    if base == "frame":
        path = [(0.0, 0.0), (0.0, 0.5), (0.8, 0.5), (0.8, 0.0)]
        points = [np.array(path[0])]
        for start, end, n in zip(path, path[1:], (5, 8, 5), strict=False):
            steps = np.linspace(0, 1, n + 1)[1:, None]
            points += list(np.array(start) + steps * (np.array(end) - np.array(start)))
        places, section = np.array(points), (4e-4, 1.333e-8 / 4)
    else:
        n, length = (52, 1.3) if base == "fine bar" else (20, 1.5 if base == "beam" else 0.9)
        places = np.column_stack([np.linspace(0, length, n + 1), np.zeros(n + 1)])
        section = (1.6e-4, 8.533e-10) if base == "fine bar" else (3e-4, 2.5e-9)
    n_bars = len(places) - 1
    return Bars(
        places,
        np.column_stack([np.arange(n_bars), np.arange(1, n_bars + 1)]),
        np.full(n_bars, modulus),
        np.full(n_bars, density),
        *section,
        loss_factor={"fine bar": 1e-3, "frame": 0.008}.get(base, 0.005),
        clamped={"cantilever": (0,), "frame": (0, n_bars)}.get(base, ()),
    )


def _true(model: Bars, error: str, rng: np.random.Generator) -> Bars:
    """Return the structure that the model is a model of: a little different everywhere, smoothly."""
    modulus, modulus_field, density, density_field, _, _, _, loss = SIZES[error]
    middles = model.points[model.ends].mean(axis=1)
    size = VARIATION_LENGTH * float(np.ptp(model.points, axis=0).sum())

    def varied(values: Reals, overall: float, along: float) -> Reals:
        return values * (1 + overall * rng.standard_normal()) * (1 + along * correlated(middles, size, rng))

    return replace(
        model,
        modulus=varied(model.modulus, modulus, modulus_field),
        density=varied(model.density, density, density_field),
        mode_factors=np.exp(loss * rng.standard_normal(len(model.modes[0]))),
    )


def _plan(base: str, model: Bars, rng: np.random.Generator) -> Plan:
    """Return a log book."""
    free = [node for node in range(len(model.points)) if node not in model.clamped]
    if base == "frame":  # Y moves the beam of a portal, and hardly its posts
        free = [node for node in free if model.points[node, 1] == model.points[:, 1].max()]
    n_points = min(9 if base == "fine bar" else int(rng.integers(6, 11)), len(free))
    chosen = sorted(int(node) for node in rng.choice(free, n_points, replace=False))
    hammer = bool(base != "fine bar" and rng.random() < 0.35)
    squares = model.modes[0]
    elastic = np.sqrt(squares[squares > 1e-4 * squares[8]]) / (2 * np.pi)
    highest = round(1.15 * float(elastic[int(rng.integers(5, 9))]))
    n_lines = 1601 if base == "fine bar" else int(rng.choice([401, 801]))
    lines = highest / (n_lines - 1)
    weight = float(model.density[0] * model.area * np.ptp(model.points, axis=0).sum())
    return Plan(
        driven=tuple(chosen) if hammer else (int(rng.choice(free)),),
        listening=tuple(sorted(int(n) for n in rng.choice(free, 2, replace=False)))
        if hammer
        else tuple(chosen),
        hammer=hammer,
        hann=bool(not hammer and rng.random() < 0.4),
        frequency_max=float(highest),
        n_lines=n_lines,
        averages=int(rng.integers(3, 8)) if hammer else int(rng.integers(15, 60)),
        accelerometer_mass=round(weight * float(rng.uniform(0.001, 0.01)), 4),
        armature_mass=round(weight * float(rng.uniform(0.02, 0.1)), 3),
        noise=float(np.exp(rng.uniform(np.log(1e-3), np.log(3e-2)))),
        lowest=lines * int(rng.integers(1, 20)),
        spectra=bool(rng.random() < 0.5),
    )


def _names(type_: str, number: int, plan: Plan, rng: np.random.Generator) -> Sequence[str]:
    possible = [name for name in SINGLES if not (plan.hammer and name == "stinger_axial")]
    if plan.hammer:  # one mass more on all accelerometers, one drive after the other: as a shaker has them
        possible = [name for name in possible if name != "force_transducer_mass"]
    match type_:
        case "single":
            return (possible[number % len(possible)],)
        case "pair":
            return tuple(str(name) for name in rng.choice(possible, 2, replace=False))
        case "unknown":
            return (str(rng.choice(UNKNOWN)),)
    return ()


def drawn(number: int, seed: int) -> DrawnTest:
    """Return a test by its number: the same whatever others are drawn."""
    rng = np.random.default_rng([seed, number])
    type_ = TYPES[number % len(TYPES)]
    base, error = BASES[int(rng.choice(4, p=(0.35, 0.25, 0.25, 0.15)))], ERRORS[int(rng.integers(3))]
    model = bars_of(base)
    true, plan = _true(model, error, rng), _plan(base, model, rng)
    *_, gain, mass, delay, _ = SIZES[error]
    # One accelerometer that roves has one sensitivity.
    own = rng.standard_normal(len(plan.listening)) if plan.hammer else [float(rng.standard_normal())]
    deviations = [
        *(Gain(1 + gain * float(own[i % len(own)]), i) for i in range(len(plan.listening))),
        Delay(delay * float(rng.standard_normal())),
    ]
    names = tuple(_names(type_, number, plan, rng))
    return DrawnTest(
        number,
        type_,
        base,
        error,
        model,
        true,
        plan,
        replace(plan, accelerometer_mass=plan.accelerometer_mass * (1 + mass * float(rng.standard_normal()))),
        tuple(deviations),
        names,
        tuple(hide(name, plan, model, rng) for name in names),
        int(rng.integers(2**31)),
    )
