"""Scan of every suspect at every place by coarse predictions."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from modallab.core.arrays import FloatArray
from modallab.core.place import Channels
from modallab.core.progress import Progress, part
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.residuals.residual import residual
from modallab.diagnosis.searching.robust_cost import RobustCost, line_minimum_fraction
from modallab.diagnosis.searching.scan_settings import LOSS, SCAN
from modallab.diagnosis.searching.shortlist import ListedPlace, shortlist
from modallab.diagnosis.searching.starting_values import local_minima, smallest_amounts, with_amount_scaled
from modallab.rig.effect import Effect


@dataclass(frozen=True)
class StartingPoint:
    """Starting values of a candidate for a coarse fit."""

    effect: Effect
    """The candidate with its starting values."""
    noise_inflation: float
    """Relative error added to every random error at the start."""


def scan(
    prediction: CoarsePrediction, accepted: Sequence[Effect], suspects: Sequence[Effect], progress: Progress
) -> list[StartingPoint]:
    """Return the starting points of coarse fits.

    Parameters
    ----------
    prediction
        Coarse predictions of additions to the accepted effects.
    suspects
        One effect for every kind and place.
    """
    listed = shortlist(prediction, accepted, suspects, part(progress, 0.0, 0.5))
    unmodified, cost = _vector(prediction, accepted), RobustCost(prediction)
    start = prediction.project_out(unmodified, 0.0)
    candidates: list[list[Effect]] = []
    costs: list[FloatArray] = []
    refined: list[bool] = []
    for kind, places in _by_kind(listed):
        progress(0.5 + 0.5 * len(candidates) / len(listed), f"scanning {kind}")
        sizes = [place.sizes for place in places]
        for values, place_costs in _costs_at_places(prediction, sizes, start, cost):
            candidates.append(values)
            costs.append(place_costs)
        refined += [place.refined for place in places]
    chosen: dict[tuple[int, int], StartingPoint] = {}
    for w, noise_inflation in enumerate(LOSS.noise_inflations):
        by_value = [place_costs[:, w] for place_costs in costs]
        useful_cost = SCAN.useful_cost * float(cost.of(unmodified)[w])
        for i in _best_places(candidates, by_value, useful_cost):
            for best in local_minima(candidates[i], by_value[i]):
                chosen.setdefault((i, best), StartingPoint(candidates[i][best], noise_inflation))
    return [
        start if refined[i] else _with_best_amount(prediction, accepted, start, cost)
        for (i, _), start in chosen.items()
    ]


def _with_best_amount(
    prediction: CoarsePrediction, accepted: Sequence[Effect], start: StartingPoint, cost: RobustCost
) -> StartingPoint:
    """Return a starting point with the amount of least robust cost between the grid values beside its own.

    Of local changes of the structure: least squares find the way from one grid value to the next only where
    resonances shift by less than their bandwidths.
    """
    effect, inflation = start.effect, LOSS.noise_inflations.index(start.noise_inflation)
    if not effect.structural or effect.at is None or not smallest_amounts([effect]):
        return start

    def loss(logarithm: float) -> float:
        candidate = with_amount_scaled(effect, float(np.exp(logarithm)))
        return float(cost.of(_vector(prediction, [*accepted, candidate]))[inflation])

    low, high = SCAN.amount_shares
    trials = np.log(np.geomspace(low, high, SCAN.amount_trials))
    best = trials[int(np.argmin([loss(trial) for trial in trials]))]
    step = trials[1] - trials[0]
    found = scipy.optimize.minimize_scalar(
        loss, bounds=(best - step, best + step), method="bounded", options={"maxiter": SCAN.amount_steps}
    )
    if not found.fun < loss(0.0):
        return start
    return replace(start, effect=with_amount_scaled(effect, float(np.exp(found.x))))


def _best_places(
    candidates: Sequence[list[Effect]], costs: Sequence[FloatArray], useful_cost: float
) -> list[int]:
    """Return the places of least cost, and the best place of each kind that is of any use.

    The latter so that many places of one kind displace no other kind. Effects on the whole model are
    chosen in any case: their narrow minimum may lie between the values of the grid.
    """
    lowest = [float(cost.min()) for cost in costs]
    order = sorted(range(len(candidates)), key=lambda i: lowest[i])
    first_of_kind = {
        (candidates[i][0].kind, candidates[i][0].at is None): i
        for i in reversed(order)
        if lowest[i] < useful_cost or (candidates[i][0].at is None and candidates[i][0].structural)
    }
    return [*order[: SCAN.max_starts], *first_of_kind.values()]


def _vector(prediction: CoarsePrediction, effects: Sequence[Effect]) -> FloatArray:
    """Return the residuals (n_residuals,) of a coarse prediction."""
    observed = prediction.observed
    return residual(observed, prediction.predict(effects)).vector(observed.fitted)


def _by_kind(listed: Sequence[ListedPlace]) -> Iterator[tuple[str, list[ListedPlace]]]:
    """Yield the kinds with their places: those of single channels together, each other place alone."""
    of_channels: dict[str, list[ListedPlace]] = {}
    for place in listed:
        effect = place.sizes[0]
        if isinstance(effect.at, Channels):
            of_channels.setdefault(effect.kind, []).append(place)
        else:
            yield effect.kind, [place]
    yield from of_channels.items()


def _costs_at_places(
    prediction: CoarsePrediction, places: Sequence[list[Effect]], start: FloatArray, cost: RobustCost
) -> list[tuple[list[Effect], FloatArray]]:
    """Return the values of an effect at each place with their costs, (n_values, n_inflations).

    Parameters
    ----------
    start
        Residuals without the effect, nuisance parameters projected out.
    """
    values = [list(sizes) for sizes in places]
    costs = [np.empty((len(sizes), len(LOSS.noise_inflations))) for sizes in places]
    smallest = [smallest_amounts(sizes) for sizes in places]
    scaled: list[tuple[int, Effect]] = []
    # Values of one rank follow each other: in channels of separate runs they are predicted together.
    trials = sorted(((p, k) for p in range(len(places)) for k in range(len(places[p]))), key=lambda t: t[1])
    for first in range(0, len(trials), SCAN.predictions_at_once):
        chosen = trials[first : first + SCAN.predictions_at_once]
        vectors = _vectors(prediction, [places[p][k] for p, k in chosen])
        for (p, k), vector, value_costs in zip(chosen, vectors, cost.of(vectors), strict=True):
            costs[p][k] = value_costs
            # Where residuals are no larger than noise the best amount is below any of the grid.
            if k in smallest[p] and (share := line_minimum_fraction(start, cost.project_out(vector))):
                scaled.append((p, with_amount_scaled(places[p][k], share)))
    if scaled:
        of_scaled = cost.of(_vectors(prediction, [effect for _, effect in scaled]))
        for (p, effect), value_costs in zip(scaled, of_scaled, strict=True):
            values[p].append(effect)
            costs[p] = np.vstack([costs[p], value_costs])
    return list(zip(values, costs, strict=True))


def _vectors(prediction: CoarsePrediction, additions: Sequence[Effect]) -> FloatArray:
    """Return the residuals (n_additions, n_residuals) beside each of some additions."""
    observed = prediction.observed
    return np.array(
        [
            residual(observed, predicted).vector(observed.fitted)
            for predicted in prediction.predict_each(additions)
        ]
    )
