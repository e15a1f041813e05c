"""A first look at every effect at every place, cheap enough for hundreds of them."""

from collections.abc import Sequence
from dataclasses import dataclass

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
RATIOS = np.array([0.1, 0.3, 0.6, 0.85, 0.98, 0.998, 1.002, 1.02, 1.2, 1.6, 3.0, 8.0])


@dataclass(frozen=True)
class Start:
    """An effect at a place with a value from which a fit should start, and how blurred to start it."""

    effect: Effect
    widening: float


def grid(spec: ParameterSpec, default: float) -> FloatArray:
    """Return values to try: on both sides of `absent`, or half decades round a believable one."""
    values = spec.absent * RATIOS if spec.absent > 0 else default * 10.0 ** np.arange(-3, 3.01, 0.5)
    return np.asarray(values[(values > spec.lower) & (values <= spec.upper)])


def scan(
    glimpses: Glimpses, accepted: Sequence[Effect], suspects: Sequence[Effect], progress: Progress
) -> list[Start]:
    """Return the starts worth a fit.

    Parameters
    ----------
    glimpses
        First looks round the accepted effects.
    suspects
        One effect of one parameter for every kind and place.
    """
    values: list[FloatArray] = []
    costs: list[FloatArray] = []
    for i, suspect in enumerate(suspects):
        tried, cost = _tried(glimpses, accepted, suspect)
        values.append(tried)
        costs.append(cost)
        progress(i / len(suspects), f"scanning {suspect.kind}")
    chosen: dict[tuple[int, int], Start] = {}
    for w, widening in enumerate(WIDENINGS):
        order = sorted(range(len(suspects)), key=lambda i: float(costs[i][:, w].min()))
        # The best place of each kind goes on as well, and what acts everywhere: no kind is crowded out
        # by many places of another, nor a narrow valley by many wide ones.
        firsts = {(suspects[i].kind, suspects[i].at is None): i for i in reversed(order)}
        for i in [*order[:KEPT], *firsts.values()]:
            best = int(costs[i][:, w].argmin())
            name = next(iter(suspects[i].specs()))
            effect = suspects[i].with_parameters({name: float(values[i][best])})
            chosen.setdefault((i, best), Start(effect, widening))
    return list(chosen.values())


def _tried(glimpses: Glimpses, accepted: Sequence[Effect], suspect: Effect) -> tuple[FloatArray, FloatArray]:
    """Return the values tried and their cost at every widening, (n_values, n_widenings)."""
    observed = glimpses.observed
    where = observed.fitted
    ((name, spec),) = suspect.specs().items()
    values = list(grid(spec, suspect.parameters[name]))

    def vectors(extra: Sequence[Effect]) -> list[FloatArray]:
        predicted = glimpses.predict([*accepted, *extra])
        return [residual(observed, predicted, widen=widen).vector(where) for widen in WIDENINGS]

    found = [vectors([suspect.with_parameters({name: float(v)})]) for v in values]
    # Where residuals are no larger than noise the best value lies between `absent` and the nearest
    # grid point; the straight line through both says where.
    start = vectors([])[0]
    near = int(np.argmin(np.abs(np.array(values) - spec.absent)))
    slope = found[near][0] - start
    if (along := float(slope @ slope)) > 0:
        reach = -float(slope @ start) / along * (values[near] - spec.absent)
        low = spec.lower if spec.absent > spec.lower else spec.absent + 1e-3 * (values[near] - spec.absent)
        value = float(np.clip(spec.absent + reach, low, spec.upper))
        values.append(value)
        found.append(vectors([suspect.with_parameters({name: value})]))
    costs = [[HEAVY_TAIL * np.log1p(v**2 / HEAVY_TAIL).sum() for v in each] for each in found]
    return np.array(values), np.array(costs)
