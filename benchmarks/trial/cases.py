"""Sealed cases: which effects are hidden in which test, drawn from a seed and a number alone."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.trial.foreign import FOREIGN
from benchmarks.trial.hidden import GAPS, PLACES, Gauge, hide
from benchmarks.trial.mistakes import MISTAKES
from benchmarks.trial.rigs import ON_CANTILEVER, ON_FRAME, ON_HAMMER, Bench, bench, small_bench
from benchmarks.trial.tolerated import Tolerated
from modallab.core.errors import ModalLabError
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.setup import RigSetup

# The effects that the service promises to know.
KINDS = (
    "extra_mass",
    "density_error",
    "stiffness_error",
    "loss_factor_error",
    "local_damping",
    "damping_law",
    "attached_oscillator",
    "ground_spring",
    "rotational_ground_spring",
    "joint_flexibility",
    "shear_and_rotary_inertia",
    "cubic_stiffness",
    "friction",
    "drift",
    "accelerometer_mass",
    "cable_mass",
    "force_transducer_mass",
    "exciter_armature",
    "stinger_axial",
    "stinger_bending",
    "suspension",
    "mounted_resonance",
    "transverse_sensitivity",
    "gain_error",
    "polarity",
    "swapped_channels",
    "misplaced_accelerometer",
    "channel_delay",
    "ac_coupling",
    "response_noise",
    "force_noise",
    "mains_hum",
    "leakage",
    "quantisation",
    "overload",
    "double_hit",
)
# Kinds that joined the catalogue after sets 1 to 3 were drawn: they have a set of their own.
LATER_KINDS = ("integrated_response", "elastic_support", "rotational_elastic_support")
SETS = ("1", "2", "3", "3a", "4")
NOISES = (1e-5, 1e-4, 1e-3)
# After one single of each kind, a round goes on with these.
OTHER_TYPES = ("pair",) * 6 + ("nothing",) * 4 + ("unknown",) * 4 + ("log_book",) * 2
ROUND = len(KINDS) + len(OTHER_TYPES)
NEARLY = 0.95  # of the least gap: logarithms of strengths are found to a thousandth
# Signals that do not repeat leak already, and no hammer plays them.
NOT_LEAKING = ("leakage", "double_hit")
# Of no other kind's doing: what stays to be found when the kind itself is not looked for is nothing.
UNMISTAKABLE = (
    "attached_oscillator",
    "channel_delay",
    "damping_law",
    "density_error",
    "drift",
    "gain_error",
    "joint_flexibility",
    "mains_hum",
    "misplaced_accelerometer",
    "mounted_resonance",
    "polarity",
    "rotational_ground_spring",
    "stiffness_error",
    "swapped_channels",
)
PAIRED = tuple(k for k in KINDS if k not in (*ON_FRAME, *ON_CANTILEVER, *ON_HAMMER))


@dataclass(frozen=True)
class Case:
    """One sealed case."""

    number: int
    set: str
    type: str  # single, pair, nothing, unknown, log_book
    bench: Bench  # the model, and the rig as declared
    truth: tuple[Effect, ...]  # what is hidden; of a wrong log book, what amounts to it
    gap: float  # that it opens in expectation
    seed: int  # of the measurement
    setup: RigSetup  # by which it is measured
    excluded: tuple[str, ...] = ()  # kinds that the diagnosis must not look for
    description: str = ""  # in a word, where the truth alone is not enough
    deviating: tuple[Effect, ...] = ()  # within tolerances

    @property
    def acting(self) -> tuple[Effect, ...]:
        """All that acts in the measurement beside what `setup` implies."""
        return (*self.deviating, *(() if self.type == "log_book" else self.truth))

    @property
    def suspects(self) -> list[str] | None:
        """Kinds that the diagnosis may look for; None for all."""
        if not self.excluded:
            return None
        return [kind for kind, cls in EFFECTS.items() if cls.suspected and kind not in self.excluded]

    @property
    def tolerances(self) -> bool:
        """Whether the test deviates from its model within tolerances."""
        return self.set in ("3", "3a")


def case(number: int, seed: int, set_name: str = "1") -> Case:
    """Return a case: the same whatever others are drawn with it.

    Parameters
    ----------
    which
        One of `SETS`; 3a has the cases of 3.
    """
    of_set = {"1": 1, "2": 2, "3": 3, "3a": 3, "4": 4}[set_name]
    rng = np.random.default_rng(np.random.SeedSequence(entropy=(seed, of_set), spawn_key=(number,)))
    kinds, length = (LATER_KINDS, len(LATER_KINDS)) if of_set == 4 else (KINDS, ROUND)
    noise, leaking = NOISES[(number + number // length) % len(NOISES)], of_set == 2
    draw = _Draw(number, set_name, rng, noise, leaking, of_set == 3)
    type_ = type_of(number, set_name)
    if type_ == "single":
        return draw.single(kinds[number % length])
    return {
        "pair": draw.pair,
        "nothing": draw.without_effect,
        "unknown": draw.unknown,
        "log_book": draw.log_book,
    }[type_]()


def type_of(number: int, set_name: str = "1") -> str:
    """Return of which type a case of this number is."""
    if set_name == "4":
        return "single"
    place = number % ROUND
    return "single" if place < len(KINDS) else OTHER_TYPES[place - len(KINDS)]


def small_case(kind: str | None, seed: int, among: Sequence[str]) -> Case:
    """Return a quick case on a short beam, with one effect or none, of which few are suspected."""
    rng = np.random.default_rng(seed)
    draw = _Draw(seed, "1", rng, 1e-4, False, False)
    bench = small_bench(rng, noise=1e-4)
    remaining_kinds = [name for name in EFFECTS if name not in among]
    if kind is None:
        return draw.sealed("nothing", bench, (), 1.0, excluded=remaining_kinds)
    effect, gap = hide(kind, bench, rng, lambda effect: Gauge(bench).opened([effect]), least=10.0)
    return draw.sealed("single", bench, (effect,), gap, excluded=remaining_kinds)


@dataclass(frozen=True)
class _Draw:
    """What the cases of one number are drawn with."""

    number: int
    set: str
    rng: np.random.Generator
    noise: float
    leaking: bool
    tolerant: bool

    def bench(self, *kinds: str) -> Bench:
        return bench(kinds, self.rng, noise=self.noise, leaking=self.leaking)

    def tolerated(self, bench: Bench) -> Tolerated:
        return Tolerated(bench, tolerant=self.tolerant)

    def visible(
        self, kinds: Sequence[str], bench: Bench
    ) -> tuple[tuple[Effect, ...], float, tuple[Effect, ...]]:
        """Return an effect of each kind, the gap of all, and deviations that none of them hides behind."""
        tolerated = self.tolerated(bench)
        for _ in range(PLACES):
            hidden = tuple(
                hide(k, bench, self.rng, lambda effect: tolerated.gauge.opened([effect]))[0] for k in kinds
            )
            deviating = tolerated.deviations(self.rng)
            unexplained = min(tolerated.unexplained([*deviating, effect]) for effect in hidden)
            if unexplained >= GAPS[0] * NEARLY:
                gap = tolerated.unexplained([*deviating, *hidden])
                return hidden, gap, deviating
        raise ModalLabError(f"{', '.join(kinds)} cannot be seen beyond what is tolerated")

    def sealed(
        self,
        type_: str,
        bench: Bench,
        truth: Sequence[Effect],
        gap: float,
        *,
        setup: RigSetup | None = None,
        excluded: Sequence[str] = (),
        description: str = "",
        deviating: Sequence[Effect] | None = None,
    ) -> Case:
        if deviating is None:
            deviating = self.tolerated(bench).deviations(self.rng)
        seed = int(self.rng.integers(2**31))
        return Case(
            self.number,
            self.set,
            type_,
            bench,
            tuple(truth),
            gap,
            seed,
            setup or bench.setup,
            tuple(excluded),
            description,
            tuple(deviating),
        )

    def possible(self, kinds: Sequence[str]) -> list[str]:
        return [k for k in kinds if not (self.leaking and k in NOT_LEAKING)]

    def single(self, kind: str) -> Case:
        if kind not in self.possible((kind,)):
            kind = str(self.rng.choice(self.possible(KINDS)))
        bench = self.bench(kind)
        hidden, gap, deviating = self.visible((kind,), bench)
        return self.sealed("single", bench, hidden, gap, deviating=deviating)

    def pair(self) -> Case:
        kinds = [str(k) for k in self.rng.choice(self.possible(PAIRED), size=2, replace=False)]
        bench = self.bench(*kinds)
        hidden, gap, deviating = self.visible(kinds, bench)
        return self.sealed("pair", bench, hidden, gap, deviating=deviating)

    def without_effect(self) -> Case:
        return self.sealed("nothing", self.bench(), (), 1.0)

    def unknown(self) -> Case:
        """Return a case with an effect out of the catalogue, foreign or taken out of it, in turn."""
        foreign = bool(self.number % 2)
        kind = str(self.rng.choice(list(FOREIGN) if foreign else self.possible(UNMISTAKABLE)))
        bench = self.bench(kind)
        hidden, gap, deviating = self.visible((kind,), bench)
        without = () if foreign else (kind,)
        return self.sealed("unknown", bench, hidden, gap, excluded=without, deviating=deviating)

    def log_book(self) -> Case:
        """Return a case whose log book is wrong by a believable factor, so that it can be seen."""
        bench = self.bench()
        gauge = self.tolerated(bench).gauge
        for name in self.rng.permutation(list(MISTAKES)):
            setup, amounts = MISTAKES[str(name)](bench.setup, self.rng)
            try:
                gap = gauge.opened([], setup)
            except ModalLabError:
                continue
            if gap >= GAPS[0]:
                return self.sealed("log_book", bench, amounts, gap, setup=setup, description=str(name))
        raise ModalLabError("no mistake of this log book can be seen")
