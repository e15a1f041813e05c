"""Starting values of an effect's parameters on a coarse grid."""

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.parameters import ParameterSpec
from modallab.diagnosis.searching.scan_settings import STARTING_VALUES
from modallab.rig.effect import Effect


def scan_grid(spec: ParameterSpec, default: float) -> FloatArray:
    """Return grid values (n,) of a parameter: about its neutral value, or decades about a typical one.

    Of a place or shape: the values that its specification lists, or the typical one.
    """
    step = STARTING_VALUES.grid_step
    if spec.scan_values or spec.absent is None:
        return np.array(spec.scan_values or (default,))
    if spec.signed:
        low, high = STARTING_VALUES.signed_decades
        steps = abs(default - spec.absent) * 10.0 ** np.arange(low, high + step / 25, step)
        values = spec.absent + np.concatenate([-steps[::-1], steps])
    elif spec.absent > 0:
        values = spec.absent * np.array(STARTING_VALUES.ratios)
    else:
        decades = STARTING_VALUES.decades
        values = default * 10.0 ** np.arange(-decades, decades + step / 25, step)
    return np.asarray(values[(values > spec.lower) & (values <= spec.upper)])


def scan_sizes(suspect: Effect, values: Mapping[str, Sequence[float]]) -> list[Effect]:
    """Return a suspect with every combination of grid values; itself if it has no parameter.

    Parameters
    ----------
    values
        Values that the suspect proposes for this test, by parameter.
    """
    defaults = suspect.parameters
    choices = [
        [(name, v) for v in values.get(name, ()) or scan_grid(spec, defaults[name])]
        for name, spec in suspect.specs().items()
    ]
    return [suspect.with_parameters({n: float(v) for n, v in chosen}) for chosen in product(*choices)]


def smallest_amounts(sizes: Sequence[Effect]) -> list[int]:
    """Return the indices of the smallest amounts, on either side of the neutral value."""
    name, spec = next(iter(sizes[0].specs().items()), ("", None))
    if spec is None or spec.absent is None:
        return []
    amounts = np.array([effect.parameters[name] for effect in sizes]) - spec.absent
    smallest = [np.abs(amounts[side]).min() for side in (amounts > 0, amounts < 0) if side.any()]
    return [i for i, amount in enumerate(amounts) if amount and abs(amount) in smallest]


def local_minima(sizes: Sequence[Effect], costs: FloatArray) -> list[int]:
    """Return the indices of values (n_values,) at local minima of the cost along the amount, best first.

    At every amount the best values of the other parameters count. Minima far above the best one, and
    those beyond the best few, are left out.
    """
    by_amount, places = _minima_by_amount(sizes, costs)
    return [by_amount[i] for i in places]


def near_minima(sizes: Sequence[Effect], costs: FloatArray) -> list[int]:
    """Return the indices of values at local minima, as `local_minima`, and of those beside them."""
    by_amount, places = _minima_by_amount(sizes, costs)
    beside = {i + step for i in places for step in (-1, 0, 1)}
    return [by_amount[i] for i in sorted(beside) if 0 <= i < len(by_amount)]


def _minima_by_amount(sizes: Sequence[Effect], costs: FloatArray) -> tuple[list[int], list[int]]:
    """Return the indices of the best values at each amount, rising, and where among them minima are."""
    name = next(iter(sizes[0].specs()), None)
    if name is None:
        return [int(costs.argmin())], [0]
    best: dict[float, int] = {}
    for i in np.argsort(costs):
        best.setdefault(sizes[i].parameters[name], int(i))
    by_amount = [best[amount] for amount in sorted(best)]
    curve = np.concatenate([[np.inf], costs[by_amount], [np.inf]])
    minima = np.flatnonzero((curve[1:-1] < curve[:-2]) & (curve[1:-1] <= curve[2:]))
    order = minima[np.argsort(curve[1:-1][minima])][: STARTING_VALUES.max_minima]
    lowest = costs[by_amount[order[0]]] if len(order) else np.inf
    return by_amount, [
        int(i) for i in order if costs[by_amount[i]] <= STARTING_VALUES.max_cost_ratio * lowest
    ]


def with_amount_scaled(effect: Effect, share: float) -> Effect:
    """Return an effect with its amount multiplied by a share, within its bounds."""
    name, spec = next(iter(effect.specs().items()))
    neutral = 0.0 if spec.absent is None else spec.absent
    amount = effect.parameters[name] - neutral
    low = spec.lower if neutral > spec.lower else neutral + STARTING_VALUES.min_share * abs(amount)
    return effect.with_parameters({name: float(np.clip(neutral + share * amount, low, spec.upper))})
