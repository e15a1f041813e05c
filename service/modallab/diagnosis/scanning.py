"""A first look at every effect at every place, cheap enough for hundreds of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.parameters import ParameterSpec
from modallab.core.progress import Progress
from modallab.diagnosis.predictor import Glimpses
from modallab.diagnosis.residual import residual
from modallab.rig.effect import Effect

WIDENINGS = (0.0, 0.03, 0.3)  # from residuals of the size of noise to modes that sit elsewhere
HEAVY_TAIL = 9.0  # squared residual beyond which a line only says "wrong", not how wrong
KEPT = 5  # starts that each widening sends on
USEFUL = 0.99  # of the cost without it that a kind must come below to be sent on beside those
RATIOS = np.array([0.1, 0.3, 0.6, 0.85, 0.98, 0.998, 1.002, 1.02, 1.2, 1.6, 3.0, 8.0])


@dataclass(frozen=True)
class Start:
    """An effect at a place with a value from which a fit should start, and how blurred to start it."""

    effect: Effect
    widening: float


def grid(spec: ParameterSpec, default: float) -> FloatArray:
    """Return values to try: on both sides of `absent`, or half decades round a believable one.

    Of a number that only says how an effect acts: what it declares worth a look, or the believable one.
    """
    if spec.tries or spec.absent is None:
        return np.array(spec.tries or (default,))
    if spec.signed:
        steps = abs(default - spec.absent) * 10.0 ** np.arange(-2, 1.01, 0.5)
        values = spec.absent + np.concatenate([-steps[::-1], steps])
    elif spec.absent > 0:
        values = spec.absent * RATIOS
    else:
        values = default * 10.0 ** np.arange(-3, 3.01, 0.5)
    return np.asarray(values[(values > spec.lower) & (values <= spec.upper)])


def variants(suspect: Effect, looks: Mapping[str, Sequence[float]]) -> list[Effect]:
    """Return a suspect with every combination of values worth a first look; itself if it has no number.

    Parameters
    ----------
    looks
        What the suspect says is worth a look in this test, by parameter.
    """
    own = suspect.parameters
    choices = [
        [(name, v) for v in looks.get(name, ()) or grid(spec, own[name])]
        for name, spec in suspect.specs().items()
    ]
    return [suspect.with_parameters({n: float(v) for n, v in chosen}) for chosen in product(*choices)]


def scan(
    glimpses: Glimpses, accepted: Sequence[Effect], suspects: Sequence[Effect], progress: Progress
) -> list[Start]:
    """Return the starts worth a fit.

    Parameters
    ----------
    glimpses
        First looks round the accepted effects.
    suspects
        One effect for every kind and place.
    """
    values: list[list[Effect]] = []
    costs: list[FloatArray] = []
    nothing = _vectors(glimpses, accepted)
    for i, suspect in enumerate(suspects):
        tried, cost = _tried(glimpses, accepted, suspect, nothing)
        values.append(tried)
        costs.append(cost)
        progress(i / len(suspects), f"scanning {suspect.kind}")
    chosen: dict[tuple[int, int], Start] = {}
    for w, widening in enumerate(WIDENINGS):
        order = sorted(range(len(suspects)), key=lambda i: float(costs[i][:, w].min()))
        # The best place of each kind goes on as well, if it is of any use: no kind is crowded out by many
        # places of another. So does what acts on all of a model: its narrow valley may lie between values.
        useful = USEFUL * _cost(nothing[w])
        firsts = {
            (suspects[i].kind, suspects[i].at is None): i
            for i in reversed(order)
            if float(costs[i][:, w].min()) < useful or (suspects[i].at is None and suspects[i].structural)
        }
        for i in [*order[:KEPT], *firsts.values()]:
            best = int(costs[i][:, w].argmin())
            chosen.setdefault((i, best), Start(values[i][best], widening))
    return list(chosen.values())


def _vectors(glimpses: Glimpses, effects: Sequence[Effect]) -> list[FloatArray]:
    """Return the residuals of a first look at every widening."""
    observed, predicted = glimpses.observed, glimpses.predict(effects)
    return [residual(observed, predicted, widen=widen).vector(observed.fitted) for widen in WIDENINGS]


def _cost(vector: FloatArray) -> float:
    return float(HEAVY_TAIL * np.log1p(vector**2 / HEAVY_TAIL).sum())


def _tried(
    glimpses: Glimpses, accepted: Sequence[Effect], suspect: Effect, nothing: Sequence[FloatArray]
) -> tuple[list[Effect], FloatArray]:
    """Return the variants tried and their cost at every widening, (n_variants, n_widenings).

    Parameters
    ----------
    nothing
        Residuals without any variant at every widening.
    """
    predictor = glimpses.predictor
    tried = variants(suspect, suspect.looks(predictor.system, predictor.setup))
    found = [_vectors(glimpses, [*accepted, effect]) for effect in tried]
    if between := _between(suspect, tried, nothing[0], [v[0] for v in found]):
        tried.append(between)
        found.append(_vectors(glimpses, [*accepted, between]))
    return tried, np.array([[_cost(vector) for vector in each] for each in found])


def _between(
    suspect: Effect, tried: Sequence[Effect], start: FloatArray, found: Sequence[FloatArray]
) -> Effect | None:
    """Return the variant where the straight line from nothing to a small amount is lowest.

    Where residuals are no larger than noise the best amount lies between `absent` and the nearest
    one tried.
    """
    name, spec = next(iter(suspect.specs().items()), ("", None))
    if spec is None or spec.absent is None:
        return None
    away = np.array([effect.parameters[name] for effect in tried]) - spec.absent
    least = np.flatnonzero(np.abs(away) == np.abs(away).min())
    near = min((int(i) for i in least), key=lambda i: float(found[i] @ found[i]))
    slope = found[near] - start
    if not (along := float(slope @ slope)) > 0:
        return None
    reach = -float(slope @ start) / along * float(away[near])
    low = spec.lower if spec.absent > spec.lower else spec.absent + 1e-3 * float(away[near])
    return tried[near].with_parameters({name: float(np.clip(spec.absent + reach, low, spec.upper))})
