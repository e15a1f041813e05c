"""A first look at every effect at every place, cheap enough for hundreds of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.progress import Progress, part
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.residuals.residual import residual
from modallab.diagnosis.searching.robust_cost import NOISE_INFLATIONS, Costs, line_minimum_fraction
from modallab.diagnosis.searching.shortlist import shortlist
from modallab.diagnosis.searching.starting_values import local_minima, smallest_amounts, with_amount_scaled
from modallab.rig.effect import Effect

KEPT = 5  # starts that each widening sends on
USEFUL = 0.99  # of the cost without it that a kind must come below to be sent on beside those


@dataclass(frozen=True)
class StartingPoint:
    """An effect at a place with a value from which a fit should start, and how blurred to start it."""

    effect: Effect
    widening: float


def scan(
    glimpses: CoarsePrediction, accepted: Sequence[Effect], suspects: Sequence[Effect], progress: Progress
) -> list[StartingPoint]:
    """Return the starts worth a fit.

    Parameters
    ----------
    glimpses
        First looks round the accepted effects.
    suspects
        One effect for every kind and place.
    """
    worth = shortlist(glimpses, accepted, suspects, part(progress, 0.0, 0.5))
    nothing, cost = _vector(glimpses, accepted), Costs(glimpses)
    cleared = glimpses.project_out(nothing, 0.0)
    tried: list[list[Effect]] = []
    costs: list[FloatArray] = []
    for i, sizes in enumerate(worth):
        progress(0.5 + 0.5 * i / len(worth), f"scanning {sizes[0].kind}")
        looked_at, left = _tried(glimpses, accepted, sizes, cleared)
        tried.append(looked_at)
        costs.append(cost.of(left))
    chosen: dict[tuple[int, int], StartingPoint] = {}
    for w, widening in enumerate(NOISE_INFLATIONS):
        order = sorted(range(len(tried)), key=lambda i: float(costs[i][:, w].min()))
        # The best place of each kind goes on as well, if it is of any use: no kind is crowded out by many
        # places of another. So does what acts on all of a model: its narrow valley may lie between values.
        useful = USEFUL * float(cost.of(nothing)[w])
        firsts = {
            (tried[i][0].kind, tried[i][0].at is None): i
            for i in reversed(order)
            if float(costs[i][:, w].min()) < useful or (tried[i][0].at is None and tried[i][0].structural)
        }
        for i in [*order[:KEPT], *firsts.values()]:
            for best in local_minima(tried[i], costs[i][:, w]):
                chosen.setdefault((i, best), StartingPoint(tried[i][best], widening))
    return list(chosen.values())


def _vector(glimpses: CoarsePrediction, effects: Sequence[Effect]) -> FloatArray:
    """Return the residuals of a first look."""
    observed = glimpses.observed
    return residual(observed, glimpses.predict(effects)).vector(observed.fitted)


def _tried(
    glimpses: CoarsePrediction, accepted: Sequence[Effect], sizes: Sequence[Effect], start: FloatArray
) -> tuple[list[Effect], FloatArray]:
    """Return sizes of an effect at a place and the residuals of each, (n_sizes, n_residuals).

    Parameters
    ----------
    start
        Residuals without any of them, less what tolerances explain.
    """
    tried = list(sizes)
    found = [_vector(glimpses, [*accepted, effect]) for effect in tried]
    for i in smallest_amounts(tried):
        # Where residuals are no larger than noise the best size is smaller than any that is tried.
        if share := line_minimum_fraction(start, glimpses.project_out(found[i], 0.0)):
            tried.append(with_amount_scaled(tried[i], share))
            found.append(_vector(glimpses, [*accepted, tried[-1]]))
    return tried, np.array(found)
