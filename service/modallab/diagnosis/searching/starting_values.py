"""The sizes of an effect that a first look tries."""

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.parameters import ParameterSpec
from modallab.rig.effect import Effect

RATIOS = np.array([0.1, 0.3, 0.6, 0.85, 0.98, 0.998, 1.002, 1.02, 1.2, 1.6, 3.0, 8.0])

VALLEYS = 3  # sizes of an effect at a place that are looked at further
COMPARABLE = 3.0  # times the cost of the best size that the others may have


def scan_grid(spec: ParameterSpec, default: float) -> FloatArray:
    """Return values to try: on both sides of `absent`, or quarter decades round a believable one.

    Of a number that only says how an effect acts: what it declares worth a look, or the believable one.
    """
    if spec.scan_values or spec.absent is None:
        return np.array(spec.scan_values or (default,))
    if spec.signed:
        steps = abs(default - spec.absent) * 10.0 ** np.arange(-2, 1.01, 0.25)
        values = spec.absent + np.concatenate([-steps[::-1], steps])
    elif spec.absent > 0:
        values = spec.absent * RATIOS
    else:
        values = default * 10.0 ** np.arange(-3, 3.01, 0.25)
    return np.asarray(values[(values > spec.lower) & (values <= spec.upper)])


def scan_sizes(suspect: Effect, looks: Mapping[str, Sequence[float]]) -> list[Effect]:
    """Return a suspect with every combination of values worth a first look; itself if it has no number.

    Parameters
    ----------
    looks
        What the suspect says is worth a look in this test, by parameter.
    """
    own = suspect.parameters
    choices = [
        [(name, v) for v in looks.get(name, ()) or scan_grid(spec, own[name])]
        for name, spec in suspect.specs().items()
    ]
    return [suspect.with_parameters({n: float(v) for n, v in chosen}) for chosen in product(*choices)]


def smallest_amounts(tried: Sequence[Effect]) -> list[int]:
    """Return which of some sizes of an effect have the smallest amount, on either side of `absent`."""
    name, spec = next(iter(tried[0].specs().items()), ("", None))
    if spec is None or spec.absent is None:
        return []
    away = np.array([effect.parameters[name] for effect in tried]) - spec.absent
    near = [np.abs(away[side]).min() for side in (away > 0, away < 0) if side.any()]
    return [i for i, one in enumerate(away) if one and abs(one) in near]


def local_minima(tried: Sequence[Effect], costs: FloatArray) -> list[int]:
    """Return which of some sizes (n_sizes,) cost less than more and less of the same do, the best first.

    Of values of the other numbers the best ones count at every amount. Sizes that cost many times as much
    as the best, and those beyond the best few, are left out.
    """
    name = next(iter(tried[0].specs()), None)
    if name is None:
        return [int(costs.argmin())]
    best: dict[float, int] = {}
    for i in np.argsort(costs):
        best.setdefault(tried[i].parameters[name], int(i))
    along = [best[amount] for amount in sorted(best)]
    curve = np.concatenate([[np.inf], costs[along], [np.inf]])
    lowest = np.flatnonzero((curve[1:-1] < curve[:-2]) & (curve[1:-1] <= curve[2:]))
    near = [along[i] for i in lowest[np.argsort(curve[1:-1][lowest])][:VALLEYS]]
    return [i for i in near if costs[i] <= COMPARABLE * costs[near[0]]]


def with_amount_scaled(effect: Effect, share: float) -> Effect:
    """Return an effect whose amount is a share of what it is, within its bounds."""
    name, spec = next(iter(effect.specs().items()))
    absent = 0.0 if spec.absent is None else spec.absent
    away = effect.parameters[name] - absent
    low = spec.lower if absent > spec.lower else absent + 1e-3 * abs(away)
    return effect.with_parameters({name: float(np.clip(absent + share * away, low, spec.upper))})
