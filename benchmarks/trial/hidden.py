"""Hidden effects: how strong each kind may believably be, and one as strong as a gap asks for."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from benchmarks.trial.foreign import FOREIGN
from benchmarks.trial.rigs import Bench
from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import DivergedError, ModalLabError
from modallab.core.place import Channels, Place
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.estimation.spectra import CrossSpectra
from modallab.fe.assembly import assemble
from modallab.rig.chain import chain
from modallab.rig.distortion import check_first_order
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.expected import expected_spectra
from modallab.rig.likely_motion import likely_motion
from modallab.rig.measure import measurement_of
from modallab.rig.nonlinear_records import modal_feedbacks
from modallab.rig.setup import RigSetup

GAPS = (2.0, 1e4)
SHARE_EVERYWHERE = 0.25  # how often a kind with many places acts everywhere
PLACES = 12  # places that are tried for one at which an effect can be seen
STEP = 0.5  # in the logarithm of a strength that is too much to be predicted or measured
LADDER = 9  # strengths at which a kind is looked at first


@dataclass(frozen=True)
class Reach:
    """Sizes of a kind's first parameter between which its strength is drawn, weakest first.

    Of a factor they are how far it is from 1, up or down.
    """

    weakest: float
    strongest: float


REACH = {
    "ac_coupling": Reach(1e-6, 30.0),
    "accelerometer_mass": Reach(1e-8, 0.2),
    "attached_oscillator": Reach(1e-8, 1.0),
    "cable_mass": Reach(1e-8, 0.1),
    "channel_delay": Reach(1e-11, 1e-3),
    "cubic_damper": Reach(1e-3, 1e12),
    "cubic_stiffness": Reach(1.0, 1e18),
    "damping_law": Reach(1e-7, 1.0),
    "density_error": Reach(1e-7, 3.0),
    "double_hit": Reach(1e-6, 0.9),
    "drift": Reach(1e-8, 0.1),
    "echo": Reach(1e-7, 0.5),
    "elastic_support": Reach(1e-13, 1e-3),
    "exciter_armature": Reach(1e-7, 2.0),
    "extra_mass": Reach(1e-8, 2.0),
    "force_noise": Reach(1e-8, 1.0),
    "force_transducer_mass": Reach(1e-8, 0.3),
    "friction": Reach(1e-8, 10.0),
    "gain_bump": Reach(1e-7, 3.0),
    "gain_error": Reach(1e-7, 3.0),
    "ground_spring": Reach(1e-4, 1e7),
    "joint_flexibility": Reach(1e-11, 0.1),
    "leakage": Reach(1e-8, 1.0),
    "local_damping": Reach(1e-7, 200.0),
    "loss_factor_error": Reach(1e-6, 9.0),
    "mains_hum": Reach(1e-8, 1.0),
    "misplaced_accelerometer": Reach(1e-8, 0.03),
    "mounted_resonance": Reach(1e7, 900.0),
    "overload": Reach(8.0, 0.7),
    "quantisation": Reach(1e-6, 1.0),
    "response_noise": Reach(1e-9, 1.0),
    "rotational_elastic_support": Reach(1e-12, 1.0),
    "rotational_ground_spring": Reach(1e-5, 1e5),
    "shear_and_rotary_inertia": Reach(1e-6, 3.0),
    "stiffness_error": Reach(1e-7, 3.0),
    "stinger_axial": Reach(1e11, 1e4),
    "stinger_bending": Reach(1e-5, 1e4),
    "suspension": Reach(1e-4, 1e5),
    "transverse_sensitivity": Reach(1e-8, 0.5),
}
Opened = Callable[[Effect], float]


def spectra_of(bench: Bench, effects: Sequence[Effect], setup: RigSetup | None = None) -> CrossSpectra:
    """Return the expected spectra of a bench with effects, by another rig than declared if one is given.

    Raises
    ------
    ModalLabError
        If the effects are too much for expected spectra.
    """
    whole = chain(assemble(bench.structure), setup or bench.setup, effects)
    check_first_order(whole.runs, whole.setup.analyser, whole.source)
    return expected_spectra(whole)


class Gauge:
    """How far spectra are from what a bench predicts, in units of their random error."""

    def __init__(self, bench: Bench, deviations: Sequence[Sequence[Effect]] = ()) -> None:
        self.bench = bench
        if deviations:
            self._along = np.array([self._vector(effect)[0] for effect in deviations]).T  # (n_residuals, n)
        else:
            self._along = np.zeros((0, 0))

    def opened(
        self, effects: Sequence[Effect], setup: RigSetup | None = None, accepted: Sequence[Effect] = ()
    ) -> float:
        """Return the gap that effects open in expectation, beyond what deviations could be.

        Random error included: 1 if they do nothing, or if what is named does the same.
        """
        vector, weight = self._vector(effects, setup, accepted)
        return 1.0 + float(weight @ self._beyond(vector) ** 2)

    def distance(
        self, effects: Sequence[Effect], accepted: Sequence[Effect], setup: RigSetup | None = None
    ) -> float:
        """Return how far what was named predicts from the truth, in standard deviations of all data."""
        vector, _ = self._vector(effects, setup, accepted)
        return float(np.sqrt(max(float(vector @ self._beyond(vector)), 0.0)))

    def _beyond(self, vector: FloatArray) -> FloatArray:
        """Return what of residuals deviations do not explain.

        Each deviation, one standard deviation of it, is believed as far as one error of a datum is.
        """
        if not self._along.size:
            return vector
        along = self._along
        normal = along.T @ along + np.eye(along.shape[1])
        return np.asarray(vector - along @ np.linalg.solve(normal, along.T @ vector))

    def _vector(
        self, effects: Sequence[Effect], setup: RigSetup | None = None, accepted: Sequence[Effect] = ()
    ) -> tuple[FloatArray, FloatArray]:
        """Return whitened residuals of all lines, and weights that make the gap of their squares."""
        actual, structure = setup or self.bench.setup, self.bench.structure
        measured = measurement_of(spectra_of(self.bench, effects, setup), self.bench.setup)
        observed = observe(measured, (), fraction=0.0)
        residual = SingleTestPredictor.of(structure, self.bench.setup, observed).residual(accepted)
        # Logarithms of averages are set right for their mean, which these spectra without scatter are not.
        usual = SingleTestPredictor.of(structure, actual, observed).residual(effects)
        off = residual.frf - usual.frf
        parts = [np.sqrt(2) * off.real, np.sqrt(2) * off.imag]
        sizes = [2 * int(observed.usable.sum())] * 2
        for part, part_reference in ((residual.force, usual.force), (residual.response, usual.response)):
            if part is not None and part_reference is not None:
                same_shape = part.shape == observed.usable.shape
                usable = observed.usable if same_shape else observed.usable.any(axis=1, keepdims=True)
                usable = np.broadcast_to(usable, part.shape)
                parts.append(np.where(usable, part - part_reference, 0.0))
                sizes.append(int(usable.sum()))
        weights = [np.full(p.size, 1 / (n * (len(parts) - 1))) for p, n in zip(parts, sizes, strict=True)]
        return np.concatenate([p.ravel() for p in parts]), np.concatenate(weights)


def hide(
    kind: str, bench: Bench, rng: np.random.Generator, opened: Opened, *, least: float = GAPS[0]
) -> tuple[Effect, float]:
    """Return an effect of a kind at a random place, and the gap that it opens.

    Its strength is such that the gap is log-uniform over what of `GAPS` this kind can reach there.

    Raises
    ------
    ModalLabError
        If it can be seen at none of the places tried.
    """
    cls = FOREIGN[kind] if kind in FOREIGN else EFFECTS[kind]
    places = list(cls.places(assemble(bench.structure), bench.setup))
    if not places:
        raise ModalLabError(f"{kind} has no place on this rig")
    for _ in range(PLACES):
        spread = [place for place in places if place is not None]
        if kind == "overload" and len(bench.setup.responses) > 1:
            # All responses are a place that was added later: without it seeds draw what they drew.
            spread.remove(Channels(bench.setup.responses))
        everywhere = None in places and (not spread or rng.random() < SHARE_EVERYWHERE)
        place = None if everywhere else spread[int(rng.integers(len(spread)))]
        bare = cls(at=place).with_parameters(_besides(kind, place, bench, rng))
        sized = _sized(bare, bench, rng, opened, least)
        if sized is not None:
            return sized
    raise ModalLabError(f"{kind} cannot be seen on this rig")


def _sized(
    bare: Effect, bench: Bench, rng: np.random.Generator, opened: Opened, least: float
) -> tuple[Effect, float] | None:
    """Return the effect with a strength drawn by its gap; None if it cannot reach the least gap."""
    if bare.kind not in REACH:
        gap = opened(bare)
        return (bare, gap) if gap >= least else None
    up, share = bool(rng.integers(2)), rng.random()
    root = _of_share(bare, up, share, opened, least)
    try:
        return root and (measurable(root[0], bench), root[1])
    except DivergedError:  # where none has to be, strengths are not limited
        return _of_share(bare, up, share, lambda effect: opened(measurable(effect, bench)), least)


def measurable(effect: Effect, bench: Bench) -> Effect:
    """Return the effect; `DivergedError` if records of a bench with it cannot be stepped through time."""
    if effect.on_motion() is not None:
        modal_feedbacks(chain(assemble(bench.structure), bench.setup, [effect]).runs)
    return effect


def _of_share(
    bare: Effect, up: bool, share: float, opened: Opened, least: float
) -> tuple[Effect, float] | None:
    """Return the effect with the strength at a share of the way from the least gap to the largest."""
    span = float(np.log(REACH[bare.kind].strongest / REACH[bare.kind].weakest))
    low, high = 0.0, abs(span)

    def at(strength: float) -> Effect:
        return _of_strength(bare, strength * np.sign(span), up)

    def excess(strength: float) -> float:
        return float(np.log(max(opened(at(strength)) - 1, 1e-300)))

    # A spring strong enough to hold still is possible again: what is possible ends where it first does.
    ladder = np.linspace(low, high, LADDER)
    excesses = [_possible(excess, float(strength)) for strength in ladder]
    if None in excesses:
        ladder, high = ladder[: excesses.index(None)], float(ladder[excesses.index(None)])
        while (most := _possible(excess, high)) is None:
            high -= STEP
            if high <= low:
                return None
    else:
        most = float(excesses[-1] or 0.0)
    # Where more of it does less the strongest is not the most visible.
    for strength, excess_there in zip(ladder, excesses, strict=False):
        if excess_there is not None and most < min(excess_there, np.log(GAPS[1] - 1)):
            most, high = excess_there, float(strength)
    bottom = max(excess(low), float(np.log(least - 1)))
    top = min(most, float(np.log(GAPS[1] - 1)))
    if top <= bottom:
        return None
    ends = np.log1p(np.exp([bottom, top]))
    target = float(np.log(np.expm1(ends[0] + share * (ends[1] - ends[0]))))

    def beyond(strength: float) -> float:
        excesses = _possible(excess, strength)
        return most if excesses is None else excesses - target

    root = brentq(beyond, low, high, xtol=1e-3, maxiter=60)
    return None if _possible(excess, root) is None else (at(root), opened(at(root)))


def _possible(excess: Callable[[float], float], strength: float) -> float | None:
    try:
        return excess(strength)
    except ModalLabError:
        return None


def _of_strength(bare: Effect, strength: float, up: bool) -> Effect:
    name, spec = next(iter(bare.specs().items()))
    size = REACH[bare.kind].weakest * float(np.exp(strength))
    if spec.absent == 1:
        size = 1 + size if up else 1 / (1 + size)
    elif spec.signed and not up:
        size = -size
    return bare.with_parameters({name: float(np.clip(size, spec.lower, spec.upper))})


def _besides(kind: str, place: Place, bench: Bench, rng: np.random.Generator) -> dict[str, float]:
    """Return the numbers that only say how an effect acts, drawn anew for every case."""
    top, record = bench.setup.analyser.frequency_max, bench.setup.analyser.record_length

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    parameters: dict[str, Callable[[], dict[str, float]]] = {
        "attached_oscillator": lambda: {
            "frequency": between(0.03 * top, 0.9 * top),
            "loss_factor": between(0.01, 0.1),
        },
        "cable_mass": lambda: {"drag": between(20.0, 500.0)},
        "damping_law": lambda: {"frequency": between(30.0, 600.0)},
        "double_hit": lambda: {"delay": between(0.01 * record, 0.1 * record)},
        "echo": lambda: {"delay": between(0.02 * record, 0.3 * record)},
        "friction": lambda: {"sticking": between(0.03, 0.3) * _speed(place, bench)},
        "gain_bump": lambda: {
            "centre": float(rng.uniform(0.2, 0.8) * top),
            "width": between(0.03 * top, 0.15 * top),
        },
        "integrated_response": lambda: {
            "integrations": float(rng.choice((-1.0, 1.0, 2.0))),
            "factor": float(rng.choice((1.0, 1 / 9.81, 1e3))),
        },
        "mains_hum": lambda: {"frequency": float(rng.choice((50.0, 60.0)) + rng.normal(0.0, 0.02))},
        "mounted_resonance": lambda: {"loss": between(0.02, 0.3)},
        "stinger_bending": lambda: {"length": between(0.03, 0.15)},
        "suspension": lambda: {"loss_factor": between(0.02, 0.3)},
    }
    return parameters[kind]() if kind in parameters else {}


def _speed(place: Place, bench: Bench) -> float:
    assert isinstance(place, Dof)
    return likely_motion(assemble(bench.structure), bench.setup, place).velocity
